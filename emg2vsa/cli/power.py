"""``emg2vsa power``: the sample size of a repeated-measures, a paired or an equivalence design."""

from __future__ import annotations

import argparse

from casr.command_line import Commands, add_command, add_json, print_json

_DESIGNS = ("repeated", "paired", "equal-paired", "equal-groups")


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "power",
        run,
        "Power of a repeated-measures ANOVA, a paired t test or a test of equality, and the participants needed.",
        "The default design, repeated, is the repeated-measures ANOVA within factors. Its defaults are the paper's: 14 "
        "participants, ten repetitions, f = 0.25, alpha = 0.05. Ten measurements test a difference between "
        "repetitions; for a difference between five specimens use --measurements 5. "
        "The design paired is the two-sided paired t test of two specimens. The designs equal-paired and equal-groups "
        "are two one-sided tests (TOST) that two means are equal within --margin: on the same participants, or on two "
        "groups of as many participants each. "
        "Example: emg2vsa power --design equal-groups --participants 10 --margin 1",
    )
    parser.add_argument("--design", choices=_DESIGNS, default="repeated", help="the test (default repeated)")
    parser.add_argument(
        "--participants", type=int, default=14, metavar="N", help="people, of each group with equal-groups (default 14)"
    )
    parser.add_argument("--measurements", type=int, default=10, metavar="M", help="repeated measurements (default 10)")
    parser.add_argument(
        "--effect", type=float, metavar="F",
        help="repeated: Cohen's f (default 0.25); paired: mean difference in SD of the differences (default 0.5); "
        "equal-paired, equal-groups: true difference in SDs (default 0)",
    )  # fmt: skip
    parser.add_argument(
        "--margin", type=float, metavar="X",
        help="equal-paired, equal-groups: differences below this count as equal, in SDs (of the differences, or of "
        "each group; default 0.5)",
    )  # fmt: skip
    parser.add_argument(
        "--rho", type=float, default=0.5, metavar="R", help="correlation between measurements (default 0.5)"
    )
    parser.add_argument(
        "--epsilon", type=float, default=1.0, metavar="E", help="non-sphericity, 1/(M-1) to 1 (default 1: spherical)"
    )
    parser.add_argument("--alpha", type=float, default=0.05, metavar="P", help="significance level (default 0.05)")
    parser.add_argument("--target", type=float, default=0.8, metavar="P", help="wanted power (default 0.8)")
    parser.add_argument(
        "--convention",
        choices=("gpower", "spss"),
        default="gpower",
        help="what f means: G*Power's default, or SPSS's (default gpower)",
    )
    parser.add_argument(
        "--sensitivity", action="store_true", help="repeated: add a table of power over rho and epsilon"
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    _check(arguments)
    return _repeated(arguments) if arguments.design == "repeated" else _pair(arguments)


def _check(arguments: argparse.Namespace) -> None:
    from emg2vsa.errors import SettingError

    if arguments.margin is not None and not arguments.design.startswith("equal"):
        raise SettingError(
            "--margin", wanted="a design that tests equality", found=f"--design {arguments.design}",
            do="Use --design equal-paired or equal-groups, or leave --margin out.",
        )  # fmt: skip
    if arguments.sensitivity and arguments.design != "repeated":
        raise SettingError(
            "--sensitivity", wanted="the design repeated", found=f"--design {arguments.design}",
            do="Leave it out: the power of this design has no rho and no epsilon.",
        )  # fmt: skip


def _pair(arguments: argparse.Namespace) -> int:
    from emg2vsa.statistics.power import fewest_people
    from emg2vsa.statistics.power_pairs import effect_for_power, margin_for_power, power_paired, power_tost

    n, alpha, target = arguments.participants, arguments.alpha, arguments.target
    if arguments.design == "paired":
        effect = 0.5 if arguments.effect is None else arguments.effect
        power = float(power_paired(effect, n, alpha))
        needed = fewest_people(lambda people: power_paired(effect, people, alpha), target)
        least_name, least = "smallest_effect", float(effect_for_power(target, n, alpha))
        of = f"to find a mean difference of {effect:g} SD of the differences"
        said = f"smallest difference found with power {target:g}: {least:.3f} SD of the differences"
        who = f"{n} participants"
    else:
        margin = 0.5 if arguments.margin is None else arguments.margin
        effect = 0.0 if arguments.effect is None else arguments.effect
        two = arguments.design == "equal-groups"
        power = float(power_tost(margin, n, n if two else None, effect, alpha))
        needed = fewest_people(lambda k: power_tost(margin, k, k if two else None, effect, alpha), target)
        least_name = "smallest_margin"
        least = float(margin_for_power(target, n, n if two else None, effect, alpha))
        of = f"to find equality within {margin:g} SD where the true difference is {effect:g} SD"
        said = f"smallest margin shown with power {target:g}: {least:.3f} SD"
        who = f"two groups of {n} participants" if two else f"{n} participants"
    if arguments.json:
        print_json(
            {"design": arguments.design, "power": power, "participants_needed": needed or None, least_name: least}
        )
        return 0
    each = " in each group" if arguments.design == "equal-groups" else ""
    print(f"power {power:.4f} with {who} {of}")
    print(f"participants needed{each} for power {target:g}: {needed or 'more than a million'}")
    print(said)
    return 0


def _repeated(arguments: argparse.Namespace) -> int:
    from emg2vsa.statistics.power import MEANING, n_for_power, power_rm, power_table

    n, m, effect = arguments.participants, arguments.measurements, arguments.effect
    effect = 0.25 if effect is None else effect
    design = (effect, arguments.rho, arguments.epsilon, arguments.alpha)
    power = float(power_rm(n, m, *design, arguments.convention))
    needed = n_for_power(m, *design, arguments.target, arguments.convention)
    table = power_table(n, m, effect, alpha=arguments.alpha, power=arguments.target, convention=arguments.convention)
    if arguments.json:
        print_json(
            {
                "power": power,
                "participants_needed": needed or None,
                "sensitivity": {
                    "rho": table.rho.tolist(),
                    "epsilon": table.epsilon.tolist(),
                    "power": table.power.tolist(),
                    "participants_needed": table.people.tolist(),
                },
            }
        )
        return 0
    print(f"power {power:.4f} with {n} participants measured {m} times each")
    print(f"participants needed for power {arguments.target:g}: {needed or 'more than a million'}")
    if arguments.sensitivity:
        print("power (participants needed) over rho (down) and epsilon (across)")
        print("rho    " + "".join(f"{epsilon:>16.2f}" for epsilon in table.epsilon))
        for rho, powers, people in zip(table.rho, table.power, table.people, strict=True):
            cells = (f"{p:.4f} ({k or '>1e6'})" for p, k in zip(powers, people, strict=True))
            print(f"{rho:<7.2f}" + "".join(f"{cell:>16}" for cell in cells))
    print(f"The paper's design: {MEANING}")
    return 0
