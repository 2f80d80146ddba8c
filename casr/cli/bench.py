"""``casr bench``: time against error of the engines and their peers."""

from __future__ import annotations

import argparse
from pathlib import Path

from casr.cli.arguments import Commands, add_command, whole_number

KINDS = ("flow", "presses", "numerics")


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "bench",
        run,
        "Measure speed and error together, side by side with other libraries.",
        "flow: optical flow on frames whose motion is known. presses: initial area and CASR of simulated presses, and "
        "the stiffness they give. numerics: single against double precision, and inputs at the edge. "
        "Other libraries take part where they are installed.",
    )
    parser.add_argument("what", choices=KINDS, nargs="?", default="flow", help="default %(default)s")
    parser.add_argument("--seeds", type=whole_number, default=6, metavar="N", help="flow, numerics: pairs (default 6)")
    parser.add_argument(
        "--repetitions", type=whole_number, default=10, metavar="N",
        help="presses: of each specimen and angle (default 10)",
    )  # fmt: skip
    parser.add_argument("--jobs", type=whole_number, default=1, metavar="N", help="presses: processes (default 1)")
    parser.add_argument("--out", type=Path, metavar="DIR", help="write the tables and plots there too")


def run(arguments: argparse.Namespace) -> int:
    from casr.bench import run as measure

    measure(
        arguments.what,
        arguments.out,
        n_seeds=arguments.seeds,
        n_repetitions=arguments.repetitions,
        n_jobs=arguments.jobs,
    )
    return 0
