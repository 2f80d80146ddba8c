"""``emg2vsa clean``: remove stored results that the study as it is now does not need."""

from __future__ import annotations

import argparse
import sys

from casr.command_line import Commands, add_command, add_json, print_json
from emg2vsa.cli.arguments import add_study, add_wait, add_work, study_of


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "clean",
        run,
        "Remove stored results that no step of the study needs any more, such as those of earlier settings.",
        "This command never removes recordings, runs or reports. Everything it removes can be computed again.",
    )
    add_study(parser)
    parser.add_argument(
        "--move-virtual",
        action="store_true",
        help="also move the emulated runs of version 0.1.0 from runs/ to runs-virtual-0.1.0/",
    )
    add_work(parser)
    add_wait(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.pipeline.clean import clean, move_virtual_runs

    study, _ = study_of(arguments)
    moved = move_virtual_runs(study) if arguments.move_virtual else None
    removed, size = clean(study, wait=not arguments.no_wait, say=lambda text: print(text, file=sys.stderr))
    if arguments.json:
        print_json({"removed": removed, "bytes": size, "moved_to": None if moved is None else str(moved)})
        return 0
    print(f"{removed} result{'s' if removed != 1 else ''} removed, {size / 1e6:.1f} MB, from {study.results}")
    if moved is not None:
        print(f"The virtual runs of version 0.1.0 are now in {moved}")
    return 0
