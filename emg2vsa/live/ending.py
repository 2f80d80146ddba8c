"""How a run ended, in words for those who stand beside it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

_HOW = {
    "completed": "Completed", "stopped": "Stopped", "interrupted": "Interrupted",
    "guard": "Ended by a guard", "failed": "Ended by an error of the program",
}  # fmt: skip


@dataclass(frozen=True)
class Ending:
    """What the page says."""

    kind: Literal["good", "stopped", "guard", "danger"]
    "Danger: nobody knows that the rig is safe."
    title: str
    text: str


def read_ending(folder: Path, repetitions: int) -> Ending | None:
    """How the run in ``folder`` ended, after how many of ``repetitions`` presses; None as long as nothing says so.

    ended.json says "killed" from the start, and "killed" is never told from "still running" by the file alone.
    """
    try:
        said = json.loads((folder / "ended.json").read_text(encoding="utf-8"))
        return None if said["how"] == "killed" else _ending(said, repetitions)
    except (OSError, ValueError, TypeError, KeyError):  # not there yet, or being replaced
        return None


def _ending(said: dict[str, Any], repetitions: int) -> Ending:
    how = said["how"]
    title = _HOW[how] + (f": {said['cause']}" if said["cause"] else "")
    done = f"{said['repetitions_done']} of {repetitions} presses done"
    where = "" if how == "completed" else f", ended in phase {said['phase']}"
    why = "" if how == "stopped" else said["why"]  # the cause says it all
    sentences = [f"{done}{where}", why, *_safety(said), *said["notes"]]
    safe = said["retracted"] and said["deactivated"]
    kind: Any = "danger" if not safe else {"completed": "good", "stopped": "stopped"}.get(how, "guard")
    return Ending(kind, title, " ".join(f"{text[0].upper()}{text[1:].rstrip('.')}." for text in sentences if text))


def _safety(said: dict[str, Any]) -> tuple[str, str]:
    return (
        "Probe retracted" if said["retracted"] else "Probe NOT known to be retracted",
        "Motors off" if said["deactivated"] else "Motors NOT known to be off: cut their power",
    )
