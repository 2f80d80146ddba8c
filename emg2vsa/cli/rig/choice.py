"""What several rig commands share: the rig file, which of its runs, and the person at the terminal."""

from __future__ import annotations

import argparse
import sys
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casr.command_line import Commands, Types, add_command, answer, wanted, whole_number
from casr.terminal import note

if TYPE_CHECKING:
    from emg2vsa.lab.person import Person
    from emg2vsa.rig_file import RigFile
    from emg2vsa.rig_file.plans import Run

RIG = "rig RIG  rig file, for example studies/palpation/rig.toml\n"
CHOICE = """
--specimen NAME...  only this specimen; may be repeated
--angle DEG...  only this angle in degrees; may be repeated
--condition {high-stiffness,modular,constant-min,constant-mean,constant-max}...  only this condition; may be repeated
--mounting N...  only this mounting, from 1; may be repeated
"""
"""Which runs."""
TYPES = {"RIG": Path, "RUN": Path, "DEG": float, "N": whole_number}


def add_rig_command(
    commands: Commands, name: str, run: Any, summary: str, epilog: str, options: str, types: Types = None, **more: Any
) -> argparse.ArgumentParser:
    """``add_command`` with the words for values that rig commands share."""
    return add_command(commands, name, run, summary, epilog, options, TYPES | dict(types or {}), **more)


def file_of(arguments: argparse.Namespace) -> RigFile:
    """The rig file. StudyError as ``load_rig``."""
    from emg2vsa.rig_file import load_rig

    return load_rig(arguments.rig)


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


def _width(text: str) -> float | None:
    percent = float(text.removesuffix("%").strip())
    return percent / 100 if 0.5 <= percent <= 100 else None


width = wanted("a percentage of kappa from 0.5 to 100, such as 5", _width)
"""``5`` or ``5%`` as 0.05."""
