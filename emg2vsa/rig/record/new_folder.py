"""Where a new run is recorded: no run is ever overwritten, and none that was completed is done twice by mistake.

Emulated and measured runs never stand in for each other: those of the other kind do not count as done.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import count
from pathlib import Path

from emg2vsa.errors import DataError

PLAN_FILE = "plan.json"
KAPPA_ABOUT_FILE = "kappa.json"
"""Marks a run whose presses were judged, and says by which calibration."""
EMULATED_FILE = "emulated.json"
"""Marks the folder of a run that no hardware made, and says what it was made with."""


def new_folder(runs: Path, name: str, presses: int, *, emulated: bool) -> Path:
    """Folder for run ``name`` in ``runs``, not made yet: ``name``; ``name-2``, ``-3`` after others.

    DataError : the run has all its ``presses``, made by a rig of the same kind.
    """
    if not presses_left(runs, name, presses, emulated=emulated):
        do = "Move it away, or choose another folder with --out."
        raise DataError(runs / name, wanted="a run that is still to do", found="one with all its presses", do=do)
    return next(folder for folder in folders_of(runs, name) if not folder.exists())


def presses_left(runs: Path, name: str, presses: int, *, emulated: bool) -> int:
    """Presses that run ``name`` still lacks of ``presses``: its folders are scored together, less what is rejected.

    emulated : whether an emulated rig must have made a press, or hardware.
    """
    done = 0
    for folder in folders_of(runs, name):
        if not folder.exists():
            break
        if (folder / EMULATED_FILE).is_file() == emulated:
            done += good_presses(folder)
    return max(0, presses - done)


def good_presses(folder: Path) -> int:
    """Whole presses in the folder of a run that are not rejected; also of a run that was killed."""
    from emg2vsa.rig.record.press_counts import verdicts  # loads the log and devices, which names of files do not need

    done, said = presses_done(folder), verdicts(folder)
    if how_ended(folder) == "killed":
        done = max(said, default=0)
    rejected = sum(number <= done and verdict == "rejected" for number, (verdict, _) in said.items())
    return done - rejected


def how_ended(folder: Path) -> str | None:
    """``how`` of the folder's ended.json; None when there is none to read."""
    how = _ended(folder, "how")
    return None if how is None else str(how)


def presses_done(folder: Path) -> int:
    """Presses that the folder's ended.json counts; 0 when there is none to read."""
    done = _ended(folder, "repetitions_done")
    return done if isinstance(done, int) else 0


def _ended(folder: Path, key: str) -> object:
    try:
        value: object = json.loads((folder / "ended.json").read_text(encoding="utf-8"))[key]
    except (OSError, ValueError, TypeError, KeyError):
        return None
    return value


def over_bytes(folder: Path) -> bool:
    """False where drivers of an emulated rig skipped the wire, or an older emulated.json does not tell."""
    try:
        text = (folder / EMULATED_FILE).read_text(encoding="utf-8")
        return json.loads(text)["over_bytes"] is True
    except FileNotFoundError:
        return True
    except (OSError, ValueError, TypeError, KeyError):
        return False


def folders_of(runs: Path, name: str) -> Iterator[Path]:
    """Where run ``name`` is, or would be: endless, and used in this order without a gap."""
    return (runs / (name if number == 1 else f"{name}-{number}") for number in count(1))
