"""Rig files of versions up to 0.2.0, whose angles are in ticks of a qbmove and whose currents are in mA."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from emg2vsa.devices.qbmove.ticks import RIG_KEYS, in_degrees, in_ticks
from emg2vsa.rig.rig_settings import GuardSettings, RigSettings
from emg2vsa.study_file.problems import KeyPath, Problem, checked, shown
from emg2vsa.study_file.toml_file import read_toml

_RIG: KeyPath = ("rig",)
_GUARDS: KeyPath = ("rig", "guards")
_TABLES: dict[KeyPath, dict[str, str]] = {
    at: {old: new for old, (new, _, _) in RIG_KEYS.items() if new in {each.name for each in fields(table)}}
    for at, table in ((_RIG, RigSettings), (_GUARDS, GuardSettings))
}
"""Older key of each table to today's."""


@dataclass(frozen=True)
class Today:
    """A rig file with the keys of today.

    tables : of the file. written : place of today's key to that of the older one in the file, and the value there.
    problems : of older keys whose values do not become those of today's; these are left out of ``tables``.
    """

    tables: dict[str, Any]
    written: dict[KeyPath, tuple[KeyPath, Any]]
    problems: list[Problem]

    def placed(self, problem: Problem) -> Problem:
        """The same problem at the key that stands in the file."""
        for new, (old, value) in self.written.items():
            if problem.path[: len(new)] == new:
                before, today = shown(value), shown(_today(old, value))
                said = f"{old[-1]} = {before} is read as {new[-1]} = {today}." if today != before else ""
                do = " ".join(filter(None, (said, problem.do)))
                return replace(problem, path=(*old, *problem.path[len(new) :]), do=do)
        return problem


def with_todays_keys(tables: Mapping[str, Any]) -> Today:
    """The file of these tables, in which both spellings may stand, but not of one key."""
    found = Today(dict(tables), {}, [])
    rig = tables.get("rig")
    if isinstance(rig, dict):
        guards = rig.get("guards")
        inner = {"guards": dict(_renamed(guards, _GUARDS, found))} if isinstance(guards, dict) else {}
        found.tables["rig"] = dict(_renamed(rig, _RIG, found)) | inner
    return found


def spelled(path: Path, values: Mapping[KeyPath, object]) -> dict[KeyPath, object]:
    """``values`` of today's keys, with the key and unit of the file for those that it has in ticks or mA."""
    written = with_todays_keys(read_toml(path, "a rig file")[1]).written
    found: dict[KeyPath, object] = {}
    for new, value in values.items():
        old = written[new][0] if new in written else new
        found[old] = value if old == new else in_ticks({str(new[-1]): value})[str(old[-1])]
    return found


def _renamed(table: Mapping[str, Any], at: KeyPath, found: Today) -> Iterator[tuple[str, Any]]:
    older = _TABLES[at]
    for key, value in table.items():
        old = (*at, key)
        if key not in older:
            yield key, value
        elif older[key] in table:
            do = f"Remove one of them; {key} is that of versions up to 0.2.0."
            found.problems.append(Problem(old, f"one key, {older[key]} or {key}", "both", do))
        elif problems := _no_whole(old, value):
            found.problems.extend(problems)
        else:
            found.written[(*at, older[key])] = old, value
            yield older[key], _today(old, value)


def _no_whole(old: KeyPath, value: Any) -> list[Problem]:
    """Ticks of places are whole numbers; one, or a list of them."""
    kind = RIG_KEYS[str(old[-1])][2]
    if kind is not int:
        return []
    hint: Any = tuple[int, ...] if isinstance(value, list) else int
    return checked(hint, value, old)[1]


def _today(old: KeyPath, value: Any) -> Any:
    key = str(old[-1])
    return in_degrees({key: value})[RIG_KEYS[key][0]]
