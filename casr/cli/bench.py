"""``casr bench``: runs the benchmarks of a source checkout, which the installed package leaves out."""

from __future__ import annotations

import argparse
from pathlib import Path

from casr.cli.arguments import names
from casr.command_line import Commands, add_command, whole_number
from casr.source_checkout import benchmarks

KINDS = ("presses", "numerics")


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "bench",
        run,
        "Score simulated presses every way there is, and try the divergence on hard scenes.",
        "presses: initial area and CASR of simulated presses, and the stiffness they give. numerics: single against "
        "double precision, and inputs at the edge. Time and error beside other libraries: emg2vsa bench pins flow "
        "growth area scoring. Needs the folder benchmarks/ of a source checkout.",
    )
    parser.add_argument("what", choices=KINDS, nargs="?", default="presses", help="default %(default)s")
    parser.add_argument("--seeds", type=whole_number, default=6, metavar="N", help="numerics: pairs (default 6)")
    parser.add_argument(
        "--repetitions", type=whole_number, default=10, metavar="N",
        help="presses: of each specimen and angle (default 10)",
    )  # fmt: skip
    parser.add_argument("--jobs", type=whole_number, default=1, metavar="N", help="presses: processes (default 1)")
    parser.add_argument(
        "--world", type=names, default=(), metavar="NAMES",
        help="presses: areas, CASR, intervals and kappa in these worlds: all, tabulated, full, domes, stick, or one of "
        "them, as stick-0.43",
    )  # fmt: skip
    parser.add_argument("--out", type=Path, metavar="DIR", help="write the tables and plots there too")


def run(arguments: argparse.Namespace) -> int:
    benchmarks("tactile", "casr").run(
        arguments.what,
        arguments.out,
        n_seeds=arguments.seeds,
        n_repetitions=arguments.repetitions,
        n_jobs=arguments.jobs,
        worlds=arguments.world,
    )
    return 0
