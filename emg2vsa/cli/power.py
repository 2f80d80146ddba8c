"""``emg2vsa power``: the sample size of a repeated-measures design."""

from __future__ import annotations

import argparse

from emg2vsa.cli.arguments import Commands, add_command, add_json, print_json


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "power",
        run,
        "Power of a repeated-measures ANOVA (within factors), and the participants needed.",
        "The defaults are the paper's: 14 participants, ten repetitions, f = 0.25, alpha = 0.05. Ten measurements test a "
        "difference between repetitions; for a difference between five specimens use --measurements 5.",
    )
    parser.add_argument("--participants", type=int, default=14, metavar="N")
    parser.add_argument("--measurements", type=int, default=10, metavar="M", help="repeated measurements (default 10)")
    parser.add_argument("--effect", type=float, default=0.25, metavar="F", help="Cohen's f (default 0.25)")
    parser.add_argument("--rho", type=float, default=0.5, help="correlation between measurements (default 0.5)")
    parser.add_argument("--epsilon", type=float, default=1.0, help="non-sphericity correction (default 1)")
    parser.add_argument("--alpha", type=float, default=0.05, help="significance level (default 0.05)")
    parser.add_argument("--target", type=float, default=0.8, help="wanted power (default 0.8)")
    parser.add_argument(
        "--convention", choices=("gpower", "spss"), default="gpower", help="meaning of f (default gpower)"
    )
    parser.add_argument("--sensitivity", action="store_true", help="table of power over rho and epsilon")
    add_json(parser)
