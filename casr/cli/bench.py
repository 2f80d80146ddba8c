"""``casr bench``: runs the benchmarks of a source checkout, which the installed package leaves out."""

from __future__ import annotations

import argparse
from dataclasses import asdict

from casr.cli.arguments import Row, add_options
from casr.cli.values import AT_LEAST_1, DIR, NAMES
from casr.command_line import Commands, add_command, add_json, print_json
from casr.source_checkout import benchmarks

KINDS = ("presses", "numerics")
# fmt: off
OPTIONS: tuple[Row, ...] = (
    ("--seeds n_seeds", AT_LEAST_1, 6, "numerics: pairs (default 6)"),
    ("--repetitions n_repetitions", AT_LEAST_1, 10, "presses: of each specimen and angle (default 10)"),
    ("--jobs n_jobs", AT_LEAST_1, 1, "presses: processes (default 1)"),
    ("--world worlds", NAMES, (),
     "presses: areas, CASR, intervals and kappa in these worlds: all, tabulated, full, domes, stick, or one of them, "
     "as stick-0.43"),
    ("--out", DIR, None, "write the tables and plots there too"),
)
# fmt: on


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands, "bench", run,
        "Score simulated presses every way there is, and try the divergence on hard scenes.",
        "presses: initial area and CASR of simulated presses, and the stiffness they give. numerics: single against "
        "double precision, and inputs at the edge. Time and error beside other libraries: emg2vsa bench pins flow "
        "growth area scoring. Needs the folder benchmarks/ of a source checkout.",
    )  # fmt: skip
    parser.add_argument("what", choices=KINDS, nargs="?", default="presses", help="default %(default)s")
    add_options(parser, *OPTIONS)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    asked = {name: getattr(arguments, name) for name in ("n_seeds", "n_repetitions", "n_jobs", "worlds")}
    bench = benchmarks("tactile", "casr")
    tables = bench.run(arguments.what, arguments.out, **asked, show=not arguments.json)
    if arguments.json:
        print_json({"tables": [asdict(table) for table in tables]})
    return 0
