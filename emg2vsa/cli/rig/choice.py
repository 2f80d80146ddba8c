"""What several rig commands share: the rig file, which of its runs, and the person at the terminal."""

from __future__ import annotations

import argparse
import sys
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casr.command_line import Commands, add_command, add_json, answer, whole_number
from casr.terminal import note

if TYPE_CHECKING:
    from emg2vsa.lab.person import Person
    from emg2vsa.rig_file import RigFile
    from emg2vsa.rig_file.plans import Run

CONDITIONS = ("high-stiffness", "modular", "constant-min", "constant-mean", "constant-max")


def add_rig(parser: argparse.ArgumentParser) -> None:
    """The rig file."""
    parser.add_argument("rig", type=Path, metavar="RIG", help="rig file, for example studies/palpation/rig.toml")


def add_hand_command(
    commands: Commands, name: str, run: Any, summary: str, epilog: str, *, asks: bool = False
) -> argparse.ArgumentParser:
    """A command for a rig file and one of its two actuators. asks : it puts questions."""
    parser = add_command(commands, name, run, summary, epilog)
    add_rig(parser)
    parser.add_argument("--motor", action="store_true", help="use the rigid motor of [motor] instead of the actuator")
    if asks:
        parser.add_argument("--yes", action="store_true", help="answer yes to every question (for scripts)")
    add_json(parser)
    return parser


def add_choice(parser: argparse.ArgumentParser) -> None:
    """Which runs."""
    add = partial(parser.add_argument, action="append", default=[])
    add("--specimen", metavar="NAME", help="only this specimen; may be repeated")
    add("--angle", type=float, metavar="DEG", help="only this angle in degrees; may be repeated")
    add("--condition", choices=CONDITIONS, help="only this condition; may be repeated")
    add("--mounting", type=whole_number, metavar="N", help="only this mounting, from 1; may be repeated")


def runs_chosen(arguments: argparse.Namespace, file: RigFile) -> tuple[Run, ...]:
    """The runs asked for, or all."""
    from emg2vsa.rig_file.plans import chosen_runs

    return chosen_runs(file, arguments.specimen, arguments.angle, arguments.condition, arguments.mounting)


def person_of(arguments: argparse.Namespace) -> Person:
    """Who sits at the terminal: not asked with --yes, and told no more than what must be known with --json."""
    from emg2vsa.lab.person import NOBODY, Person

    say = NOBODY.say if arguments.json else partial(print, flush=True)
    complain = partial(print, file=sys.stderr, flush=True)
    hint = NOBODY.hint if arguments.json else complain
    return Person(say, hint, complain, note, _asked, getattr(arguments, "yes", False))


def finish(arguments: argparse.Namespace, result: Any, *lines: str, good: bool = True) -> int:
    """The result with --json, a dict or a dataclass; else these lines. Exit status."""
    answer(arguments.json, _named(result if isinstance(result, dict) else asdict(result)), lines)
    return int(not good)


def _named(value: Any) -> Any:
    """The same with tables in place of named tuples, whose names JSON would lose."""
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, dict):
        return {key: _named(each) for key, each in value.items()}
    return [_named(each) for each in value] if isinstance(value, list | tuple) else value


def _asked(question: str) -> str | None:
    print(question, end="", file=sys.stderr, flush=True)
    try:
        return input().strip()
    except EOFError:
        return None
