"""``casr bench``: runs the benchmarks of a source checkout, which the installed package leaves out."""

from __future__ import annotations

import argparse
from dataclasses import asdict

from casr.cli.arguments import names
from casr.command_line import Commands, add_command, add_json, add_options, benchmarks, print_json, whole_number

KINDS = ("presses", "kappa", "numerics")
OPTIONS = """
what [WHAT]  default %(default)s
--seeds N = 6  numerics: pairs (default %(default)s)
--repetitions N = 10  presses: of each specimen and angle; kappa: of each design (default %(default)s)
--jobs N = 1  presses, kappa: processes (default %(default)s)
--world NAMES  presses: areas, CASR, intervals and kappa in these worlds: all, tabulated, full, domes, stick, or one of
    them, as stick-0.43
--out DIR  write the tables and plots there too
"""


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands, "bench", run,
        "Score simulated presses every way there is, and try the divergence on hard scenes.",
        "presses: initial area and CASR of simulated presses, and the stiffness they give. kappa: stiffness by the "
        "pins, on domes that are left out of the tables one at a time. numerics: single against "
        "double precision, and inputs at the edge. Time and error beside other libraries: emg2vsa tools bench pins "
        "flow growth area scoring. Needs the folder benchmarks/ of a source checkout.",
    )  # fmt: skip
    types, kinds = {"N": whole_number, "NAMES": names}, {"choices": KINDS, "default": "presses", "metavar": None}
    add_options(parser, OPTIONS, types, what=kinds, world={"default": ()})
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    counts = {"n_seeds": arguments.seeds, "n_repetitions": arguments.repetitions, "n_jobs": arguments.jobs}
    bench, show = benchmarks("tactile", "casr"), not arguments.json
    tables = bench.run(arguments.what, arguments.out, **counts, worlds=arguments.world, show=show)
    if arguments.json:
        print_json({"tables": [asdict(table) for table in tables]})
    return 0
