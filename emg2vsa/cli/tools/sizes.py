"""``emg2vsa tools power`` and ``design``: how many people, specimens and presses a study needs."""

from __future__ import annotations

import argparse

from casr.command_line import JSON, Commands, add_command, answer

POWER_SUMMARY = (
    "Power of a repeated-measures ANOVA, a paired t test or a test of equality, and the participants needed."
)
POWER = """
The default design, repeated, is the repeated-measures ANOVA within factors. Its defaults are the paper's: 14
participants, ten repetitions, f = 0.25, alpha = 0.05. Ten measurements test a difference between repetitions; for a
difference between five specimens use --measurements 5. The design paired is the two-sided paired t test of two
specimens. The designs equal-paired and equal-groups are two one-sided tests (TOST) that two means are equal within
--margin: on the same participants, or on two groups of as many participants each.
Example: emg2vsa tools power --design equal-groups --participants 10 --margin 1
"""
POWER_OPTIONS = f"""
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
DESIGN_SUMMARY = "Find how many calibration specimens and presses a given precision of stiffness needs."
DESIGN = """
The command simulates whole experiments: it presses known specimens, calibrates by the compliance law and estimates. The
defaults describe the specimens of the paper and the noise of simulated presses. Use the noise and the sensor stiffness
of your own calibration.
"""
DESIGN_OPTIONS = f"""
--precision P = 0.1  half width of the interval to reach, as a share of kappa (default 0.1)
--kappa K = 5.32  stiffness to be estimated, N/mm (default 5.32)
--range X  stiffness of the softest and the stiffest known specimen, N/mm (default 1.11 7.63)
--noise S = 0.02  standard deviation of the score of a press, as a share of the score (default 0.02)
--kappa-error E = 0  relative error of each known stiffness (default 0)
--mounting M = 0  SD of a score from one mounting to the next, share of it (default 0: all specimens are mounted alike)
--sensor K = 4  stiffness of the sensor itself, N/mm (default 4)
--experiments N = 1000  number of simulated experiments for each design (default 1000)
{JSON}
"""


def add_to(commands: Commands) -> None:
    types = {"N": int, "M": int, **dict.fromkeys("FREP", float)}
    add_command(commands, "power", power, POWER_SUMMARY, POWER, POWER_OPTIONS, types)
    two = {"nargs": 2, "metavar": ("LOW", "HIGH"), "default": (1.11, 7.63)}
    add_command(
        commands,
        "design",
        design,
        DESIGN_SUMMARY,
        DESIGN,
        DESIGN_OPTIONS,
        {**dict.fromkeys("PKEM", float), "N": int},
        range=two,
    )


def power(arguments: argparse.Namespace) -> int:
    """Power of a design and the number that it needs. SettingError : an option that belongs to another design."""
    from emg2vsa.errors import SettingError
    from emg2vsa.report.outcome_text import pair_words, repeated_words
    from emg2vsa.statistics.power import n_for_power, pair_power, power_rm, power_table

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


def design(arguments: argparse.Namespace) -> int:
    import dataclasses

    from emg2vsa.calibration.design import Situation, smallest, try_designs

    situation = Situation(
        kappa=arguments.kappa, kappa_range=tuple(arguments.range), noise=arguments.noise,
        kappa_error=arguments.kappa_error, mounting_sd=arguments.mounting, sensor_n_per_mm=arguments.sensor,
    )  # fmt: skip
    designs = try_designs(situation, experiments=arguments.experiments)
    chosen = smallest(designs, arguments.precision)
    told = {
        "designs": [dataclasses.asdict(design) | {"presses": design.presses} for design in designs],
        "smallest": None if chosen is None else dataclasses.asdict(chosen),
    }
    mounted = "every specimen is mounted once" if arguments.mounting else "all specimens are mounted alike"
    lines = [
        "specimens  presses each  in all  half width  median error  coverage",
        *(
            f"{one.specimens:>9}  {one.repetitions:>12}  {one.presses:>6}  {one.half_width:>10.1%}  "
            f"{one.error:>12.1%}  {one.coverage:>8.1%}"
            for one in designs
        ),
        f"none of these designs has a half width of {arguments.precision:.0%} or less: lower the noise of a press"
        if chosen is None
        else f"smallest design for {arguments.precision:.0%}: {chosen.specimens} specimens, {chosen.repetitions} "
        f"presses of each and of the new one, {chosen.presses} in all",
        f"These are simulated experiments in which the compliance law holds and {mounted}.",
    ]
    answer(arguments.json, told, lines)
    return 0
