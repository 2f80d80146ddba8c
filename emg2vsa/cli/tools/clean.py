"""``emg2vsa tools clean``: remove stored results that the study as it is now does not need."""

from __future__ import annotations

import argparse
import sys

from casr.command_line import JSON, Commands, add_command, answer
from emg2vsa.cli.arguments import STUDY, WAIT, WORK, study_of

SUMMARY = "Remove stored results that no step of the study needs any more, such as those of earlier settings."
EPILOG = "This command never removes recordings, runs or reports. Everything it removes can be computed again."
OPTIONS = f"""
{STUDY}
--move-virtual  also move the emulated runs of version 0.1.0 from runs/ to runs-virtual-0.1.0/
{WORK}{WAIT}{JSON}
"""


def add_to(commands: Commands) -> None:
    add_command(commands, "clean", run, SUMMARY, EPILOG, OPTIONS)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.pipeline.clean import clean, move_virtual_runs

    study, _ = study_of(arguments)
    moved = move_virtual_runs(study) if arguments.move_virtual else None
    removed, size = clean(study, wait=not arguments.no_wait, say=lambda text: print(text, file=sys.stderr))
    lines = [f"{removed} result{'s' if removed != 1 else ''} removed, {size / 1e6:.1f} MB, from {study.results}"]
    if moved is not None:
        lines.append(f"The virtual runs of version 0.1.0 are now in {moved}")
    told = {"removed": removed, "bytes": size, "moved_to": None if moved is None else str(moved)}
    answer(arguments.json, told, lines)
    return 0
