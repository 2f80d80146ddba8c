"""The order of a session's presses: drawn once, before the first press, and never again.

What is drawn depends on nothing but its text: seed, name of the study and code of the participant, each on a line of
its own, and at a visit its label. How the text decides the order is told in `emg2vsa.random_order`, so that anybody
can draw it again. A design has rows, which participants take in turn; its letters are drawn by seed and study alone.
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

    drawn_at : date and time, ISO 8601. seed : of the draw; the order can be drawn again from it. visit : its label, ""
    where a participant comes once. order : what `order_of` tells.
    """

    study: str
    participant: str
    seed: int
    drawn_at: str
    presses: tuple[PlannedPress, ...]
    settings: Mapping[str, Any] = field(default_factory=dict)
    visit: str = ""
    order: Mapping[str, Any] = field(default_factory=dict)


def design(kind: Literal["latin-square", "williams"], n: int) -> list[list[int]]:
    """The rows of a design of ``n`` specimens, each a permutation of 0 to n - 1.

    latin-square: n rows; each specimen is at each place once. williams: also, each follows each other equally often;
    n rows for an even n, else 2 n, of which the second half is the first one backwards (Williams 1949,
    doi:10.1071/CH9490149).
    """
    if kind == "latin-square":
        return [[(row + j) % n for j in range(n)] for row in range(n)]
    rows = [[(row + (-(j // 2) if j % 2 == 0 else (j + 1) // 2)) % n for j in range(n)] for row in range(n)]
    return rows + [row[::-1] for row in rows] if n % 2 else rows


def order_of(specimens: Sequence[str], settings: SessionSettings, place: int) -> dict[str, Any]:
    """Kind of the order, and of a design also the place that is taken and its row, which both count from 1.

    place : of the participant among those planned, from 0, one further at each further visit.
    """
    if settings.order not in ("latin-square", "williams"):
        return {"kind": settings.order}
    rows = len(design(settings.order, len(specimens)))
    return {"kind": settings.order, "place": place + 1, "row": place % rows + 1, "rows": rows}


def draw_presses(
    study: str, participant: str, specimens: Sequence[str], settings: SessionSettings, place: int = 0, visit: str = ""
) -> tuple[PlannedPress, ...]:
    """The presses of a session in their order; ``specimens`` as the study file lists them; ``place`` as `order_of`.

    Training comes first, its specimens as listed. Then, by ``settings.order``: "blocked": the specimens shuffled, all
    presses of one in a row; "interleaved": for each repetition the specimens are shuffled anew, so that every specimen
    has been pressed as often as every other, give or take one, at any moment; "listed": as listed, for the participant
    or for all; "latin-square" and "williams": as blocked, in the order of a row of the design, see `design`.
    """
    turns = [("training", name, settings.training_repetitions) for name in settings.training_specimens]
    random = random_numbers("\n".join((str(settings.seed), study, participant, *filter(None, [visit]))))
    if settings.order == "interleaved":
        for _ in range(settings.repetitions):
            turns += [("main", name, 1) for name in shuffled(specimens, random)]
    else:
        if settings.order == "blocked":
            ordered = shuffled(specimens, random)
        elif settings.order == "listed":
            ordered = list(settings.orders.get(participant, specimens))
        else:
            letters = shuffled(specimens, random_numbers(f"{settings.seed}\n{study}"))
            rows = design(settings.order, len(letters))
            ordered = [letters[i] for i in rows[place % len(rows)]]
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
    """The settings as plan.json has them; the form of a participant and who listens are no part of a plan."""
    said = {name: value for name, value in asdict(settings).items() if name not in ("form", "lsl_outlets", "trigger")}
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
        since: dict[str, Any] = {"visit": "", "order": {}}  # keys that earlier versions did not write
        return Plan(**{each.name: (since | content)[each.name] for each in fields(Plan)} | {"presses": presses})
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
