"""Arguments that several commands share."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from emg2vsa.pipeline.plan import Board

Commands = Any  # argparse gives its collection of sub-parsers no public type


def add_command(commands: Commands, name: str, run: Any, summary: str, epilog: str = "") -> argparse.ArgumentParser:
    """A sub-command whose help opens with its one-line summary."""
    parser: argparse.ArgumentParser = commands.add_parser(
        name, help=summary, description=summary, epilog=epilog or None
    )
    parser.set_defaults(run=run)
    return parser


def add_study(parser: argparse.ArgumentParser) -> None:
    """The study file."""
    parser.add_argument(
        "study", type=Path, metavar="STUDY", help="study file, for example studies/palpation/study.toml"
    )


def add_json(parser: argparse.ArgumentParser) -> None:
    """Output for programs."""
    parser.add_argument("--json", action="store_true", help="print JSON for a program to read")


def add_jobs(parser: argparse.ArgumentParser) -> None:
    """Number of processes."""
    parser.add_argument("--jobs", type=positive, metavar="N", help="processes to use (default: all cores)")


def jobs_of(arguments: argparse.Namespace) -> int:
    """The number of processes asked for, or all cores."""
    from emg2vsa.pipeline.pool import available_cores

    return int(arguments.jobs or available_cores())


def say_not_used(board: Board) -> None:
    """One line on the error stream for every step that was refused or failed, in this run or before it."""
    for item, stage, message in board.failures():
        print(f"not used: {item} ({stage}): {message}", file=sys.stderr)


def print_json(value: object) -> None:
    """JSON with sorted keys; a number that is not finite becomes null, which every reader knows."""
    print(json.dumps(_finite(value), indent=2, sort_keys=True))


def _finite(value: object) -> object:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    if isinstance(value, float) and value - value != 0:
        return None
    return value


def positive(text: str) -> int:
    """A whole number from 1, for argparse."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"wanted a whole number from 1; found {text!r}")
    return int(text)
