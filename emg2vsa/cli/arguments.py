"""Arguments that several commands share."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from casr.command_line import whole_number

if TYPE_CHECKING:
    from emg2vsa.pipeline.plan import Board
    from emg2vsa.study import Study


def add_study(parser: argparse.ArgumentParser) -> None:
    """The study file."""
    parser.add_argument(
        "study", type=Path, metavar="STUDY", help="study file, for example studies/palpation/study.toml"
    )


def add_jobs(parser: argparse.ArgumentParser) -> None:
    """Number of processes."""
    parser.add_argument("--jobs", type=whole_number, metavar="N", help="processes to use (default: all cores)")


def add_work(parser: argparse.ArgumentParser) -> None:
    """Another place for what is written."""
    parser.add_argument(
        "--work", type=Path, metavar="DIR", help="write results, report and emulated runs into DIR, nothing elsewhere"
    )


def add_wait(parser: argparse.ArgumentParser) -> None:
    """What to do while another run holds the study."""
    parser.add_argument(
        "--no-wait", action="store_true", help="end with a message when another run holds the study, instead of waiting"
    )


def study_of(arguments: argparse.Namespace) -> tuple[Study, Path | None]:
    """The study, placed in --work where that is given, and the results beside its study file that are then read."""
    from emg2vsa.study_file import load_study

    study = load_study(arguments.study)
    if arguments.work is None:
        return study, None
    from emg2vsa.pipeline.places import placed_in

    return placed_in(study, arguments.work), study.results


def jobs_of(arguments: argparse.Namespace) -> int:
    """The number of processes asked for, or all cores."""
    from emg2vsa.pipeline.pool import available_cores

    return int(arguments.jobs or available_cores())


def say_not_used(board: Board) -> None:
    """One line on the error stream for every step that was refused or failed, in this run or before it."""
    for item, stage, message in board.failures():
        print(f"not used: {item} ({stage}): {message}", file=sys.stderr)
