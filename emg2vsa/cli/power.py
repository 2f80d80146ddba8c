"""``emg2vsa power``: the sample size of a repeated-measures design."""

from __future__ import annotations

import argparse

from casr.command_line import Commands, add_command, add_json, print_json


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "power",
        run,
        "Power of a repeated-measures ANOVA (within factors), and the participants needed.",
        "The defaults are the paper's: 14 participants, ten repetitions, f = 0.25, alpha = 0.05. Ten measurements "
        "test a difference between repetitions; for a difference between five specimens use --measurements 5.",
    )
    parser.add_argument("--participants", type=int, default=14, metavar="N", help="people (default 14)")
    parser.add_argument("--measurements", type=int, default=10, metavar="M", help="repeated measurements (default 10)")
    parser.add_argument("--effect", type=float, default=0.25, metavar="F", help="effect size, Cohen's f (default 0.25)")
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
    parser.add_argument("--sensitivity", action="store_true", help="add a table of power over rho and epsilon")
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.stats.power import MEANING, n_for_power, power_rm, power_table

    n, m = arguments.participants, arguments.measurements
    design = (arguments.effect, arguments.rho, arguments.epsilon, arguments.alpha)
    power = float(power_rm(n, m, *design, arguments.convention))
    needed = n_for_power(m, *design, arguments.target, arguments.convention)
    table = power_table(
        n, m, arguments.effect, alpha=arguments.alpha, power=arguments.target, convention=arguments.convention
    )
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
