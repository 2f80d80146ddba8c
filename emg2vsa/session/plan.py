"""The order of a session's presses: drawn once, before the first press, and never again.

The draw depends on nothing but its text: seed, name of the study and code of the participant, each on a line of its
own. How the text decides the order is told in `emg2vsa.random_order`, so that anybody can draw it again.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any, Literal

from emg2vsa.errors import DataError
from emg2vsa.random_order import random_numbers, shuffled
from emg2vsa.session_settings import SessionSettings

PLAN_FILE = "plan.json"


@dataclass(frozen=True)
class PlannedPress:
    """number : from 1, in the order of pressing. repetition : of this specimen, from 1. stay : from 1 over the whole
    session; presses on one specimen without another between them are one stay, and one recording."""

    number: int
    phase: Literal["training", "main"]
    specimen: str
    repetition: int
    stay: int


@dataclass(frozen=True)
class Plan:
    """What plan.json holds. settings : the tables of the study file that a session depends on, as they were.

    drawn_at : date and time, ISO 8601. seed : of the draw; the order can be drawn again from it.
    """

    study: str
    participant: str
    seed: int
    drawn_at: str
    presses: tuple[PlannedPress, ...]
    settings: Mapping[str, Any] = field(default_factory=dict)


def draw_presses(
    study: str, participant: str, specimens: Sequence[str], settings: SessionSettings
) -> tuple[PlannedPress, ...]:
    """The presses of a session in their order; ``specimens`` as the study file lists them.

    Training comes first, its specimens as listed. Then, by ``settings.order``: "blocked": the specimens shuffled, all
    presses of one in a row; "interleaved": for each repetition the specimens are shuffled anew, so that every specimen
    has been pressed as often as every other, give or take one, at any moment; "listed": as listed.
    """
    turns = [("training", name, settings.training_repetitions) for name in settings.training_specimens]
    random = random_numbers(f"{settings.seed}\n{study}\n{participant}")
    if settings.order == "interleaved":
        for _ in range(settings.repetitions):
            turns += [("main", name, 1) for name in shuffled(specimens, random)]
    else:
        ordered = shuffled(specimens, random) if settings.order == "blocked" else specimens
        turns += [("main", name, settings.repetitions) for name in ordered]
    presses: list[PlannedPress] = []
    done: dict[tuple[str, str], int] = {}
    stay, last = 0, ("", "")
    for phase, name, times in turns:
        stay, last = stay + ((phase, name) != last), (phase, name)
        for _ in range(times):
            done[last] = done.get(last, 0) + 1
            kind: Literal["training", "main"] = "training" if phase == "training" else "main"
            presses.append(PlannedPress(len(presses) + 1, kind, name, done[last], stay))
    return tuple(presses)


_OF_EMG = {
    "kind": "", "channels": {}, "gain": 1.0, "fs_hz": 1000.0, "range_v": 5.0, "host": "127.0.0.1",
    "command_port": 50040, "emg_port": 50043, "stream": None, "delay_s": 0.0,
}  # fmt: skip
_OF_FORCE = {
    "kind": "", "rig": None, "axis": (0.0, 0.0, -1.0), "stream": None, "channel": None, "delay_s": 0.0,
}  # fmt: skip
"""Keys that plan.json has whatever the kind, as 0.1.0 and 0.2.0 wrote it: a session begun with these is resumed."""


def planned(settings: SessionSettings) -> dict[str, Any]:
    """The settings as plan.json has them."""
    said = asdict(settings)
    return said | {"emg": _OF_EMG | said["emg"], "force": _OF_FORCE | said["force"]}


def plan_bytes(plan: Plan) -> bytes:
    """The content of plan.json."""
    return (json.dumps(asdict(plan), indent=2, ensure_ascii=False) + "\n").encode()


def read_plan(path: Path) -> Plan:
    """The plan in a file. DataError where there is none that can be read."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(content, dict):
            raise ValueError("no table")
        presses = tuple(PlannedPress(**press) for press in content["presses"])
        if any(type(n) is not int for press in presses for n in (press.number, press.repetition, press.stay)):
            raise ValueError("a press whose number, repetition or stay is no whole number")
        return Plan(**{each.name: content[each.name] for each in fields(Plan)} | {"presses": presses})
    except (OSError, ValueError, KeyError, TypeError) as error:
        if not path.parent.exists():
            do = "Check the participant's code, or run the session first."
            raise DataError(path.parent, wanted="the folder of a session", found="none", do=do) from error
        told = f"no key {error}" if isinstance(error, KeyError) else str(error)
        found = getattr(error, "strerror", None) or told
        raise DataError(
            path, wanted="the plan of a session", found=found,
            do="Put the file back from a copy. Without its plan a session cannot go on.",
        ) from error  # fmt: skip


def changes(before: Mapping[str, Any], now: Mapping[str, Any]) -> tuple[str, ...]:
    """What a study file says otherwise than when the plan was drawn: "session.rest_s was 2.0 and is 3.0"."""
    old, new = _flat(json.loads(json.dumps(before)), ""), _flat(json.loads(json.dumps(now)), "")
    return tuple(
        f"{key} was {_shown(old, key)} and is {_shown(new, key)}"
        for key in dict.fromkeys((*old, *new))
        if old.get(key) != new.get(key)
    )


def _flat(value: Any, at: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        return {at: value}
    found: dict[str, Any] = {}
    for key, inner in value.items():
        found |= _flat(inner, f"{at}.{key}" if at else key)
    return found


def _shown(values: Mapping[str, Any], key: str) -> str:
    return json.dumps(values[key], ensure_ascii=False) if values.get(key) is not None else "not set"
