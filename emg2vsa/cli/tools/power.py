"""``emg2vsa tools power``: the sample size of a repeated-measures, a paired or an equivalence design."""

from __future__ import annotations

import argparse

from casr.command_line import JSON, Commands, add_command, answer

SUMMARY = "Power of a repeated-measures ANOVA, a paired t test or a test of equality, and the participants needed."
EPILOG = """
The default design, repeated, is the repeated-measures ANOVA within factors. Its defaults are the paper's: 14
participants, ten repetitions, f = 0.25, alpha = 0.05. Ten measurements test a difference between repetitions; for a
difference between five specimens use --measurements 5. The design paired is the two-sided paired t test of two
specimens. The designs equal-paired and equal-groups are two one-sided tests (TOST) that two means are equal within
--margin: on the same participants, or on two groups of as many participants each.
Example: emg2vsa tools power --design equal-groups --participants 10 --margin 1
"""
OPTIONS = f"""
--design {{repeated,paired,equal-paired,equal-groups}} = repeated  the test (default repeated)
--participants N = 14  people, of each group with equal-groups (default 14)
--measurements M = 10  repeated measurements (default 10)
--effect F  repeated: Cohen's f (default 0.25); paired: mean difference in SD of the differences (default 0.5);
  equal-paired, equal-groups: true difference in SDs (default 0)
--margin X  equal-paired, equal-groups: differences below this count as equal, in SDs (of the differences, or of each
  group; default 0.5)
--rho R = 0.5  correlation between measurements (default 0.5)
--epsilon E = 1  non-sphericity, 1/(M-1) to 1 (default 1: spherical)
--alpha P = 0.05  significance level (default 0.05)
--target P = 0.8  wanted power (default 0.8)
--convention {{gpower,spss}} = gpower  what f means: G*Power's default, or SPSS's (default gpower)
--sensitivity  repeated: add a table of power over rho and epsilon
{JSON}
"""


def add_to(commands: Commands) -> None:
    types = {"N": int, "M": int, **dict.fromkeys("FREP", float)}
    add_command(commands, "power", run, SUMMARY, EPILOG, OPTIONS, types)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.errors import SettingError
    from emg2vsa.report.power_words import pair_words, repeated_words
    from emg2vsa.statistics.power import n_for_power, power_rm, power_table
    from emg2vsa.statistics.power_pairs import pair_power

    design, n, m, alpha, target = (
        getattr(arguments, name) for name in ("design", "participants", "measurements", "alpha", "target")
    )
    if arguments.margin is not None and not design.startswith("equal"):
        wanted, do = "a design that tests equality", "Use --design equal-paired or equal-groups, or leave --margin out."
        raise SettingError("--margin", wanted=wanted, found=f"--design {design}", do=do)
    if arguments.sensitivity and design != "repeated":
        do = "Leave it out: the power of this design has no rho and no epsilon."
        raise SettingError("--sensitivity", wanted="the design repeated", found=f"--design {design}", do=do)
    if design != "repeated":
        pair = pair_power(design, n, effect=arguments.effect, margin=arguments.margin, alpha=alpha, target=target)
        told, lines = pair_words(pair, design, n, target)
    else:
        effect = 0.25 if arguments.effect is None else arguments.effect
        numbers = (effect, arguments.rho, arguments.epsilon, alpha)
        power = float(power_rm(n, m, *numbers, arguments.convention))
        needed = n_for_power(m, *numbers, target, arguments.convention)
        table = power_table(n, m, effect, alpha=alpha, power=target, convention=arguments.convention)
        told, lines = repeated_words(power, needed, table, n, m, target, sensitivity=arguments.sensitivity)
    answer(arguments.json, told, lines)
    return 0
