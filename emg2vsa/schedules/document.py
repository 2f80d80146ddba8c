"""A schedule as a tree of plain values, the content of its files, and back with every type checked."""

from __future__ import annotations

from typing import Any

import numpy as np

from emg2vsa.devices.joints import Export, export_of, joint_names, kind_with
from emg2vsa.errors import ScheduleError
from emg2vsa.schedules.checks import EXPORT_AGAIN
from emg2vsa.schedules.schedule import Limits, Ramp, Schedule

FORMAT = "emg2vsa stiffness schedule"
VERSION = 2
"""With an interval of the stiffness in every step; a schedule without one is of version 1, as all were before 2."""
Columns = dict[str, type[int] | type[float]]
Document = dict[str, Any]
_HEAD = {
    "format": str, "version": int, "specimen": str, "condition": str, "last_step_short": bool, "ramp": dict,
    "limits": dict, "provenance": dict, "steps": list,
}  # fmt: skip
_RAMP = {
    "speed_mm_per_s": float, "gear_mm_per_degree": float, "speed_deg_per_s": float, "travel_mm": float,
    "duration_s": float,
}  # fmt: skip
_WORDS = {str: "text", int: "a whole number", float: "a number", bool: "true or false", list: "a list", dict: "a table"}


def columns_of(export: Export, version: object) -> Columns:
    """Name of each column of the steps of a file of this version, and what it holds."""
    interval: Columns = {"stiffness_low_percent": float, "stiffness_high_percent": float} if version != 1 else {}
    return {
        "force_from_n": float, "force_to_n": float, "activity_v": float, "stiffness_percent": float, **interval,
        export.column: int if export.whole else float, "stiffness_nm_per_rad": float,
    }  # fmt: skip


def document_of(schedule: Schedule) -> Document:
    """Plain values, exact: floats stay the same doubles."""
    interval, limits = schedule.interval_percent, schedule.limits
    export, version = limits.export, VERSION - (interval is None)
    columns = (
        schedule.step_force_n[:-1], schedule.step_force_n[1:], schedule.activity_v, schedule.stiffness_percent,
        *(() if interval is None else interval), schedule.exported, schedule.stiffness_nm_per_rad,
    )  # fmt: skip
    rows = zip(*(column.tolist() for column in columns), strict=True)
    return {
        "format": FORMAT,
        "version": version,
        "specimen": schedule.specimen,
        "condition": schedule.condition,
        "last_step_short": schedule.last_step_short,
        "ramp": {name: float(getattr(schedule.ramp, name)) for name in _RAMP},
        "limits": {
            "stiffness_percent": [float(v) for v in limits.stiffness_percent],
            export.limit: export.exported(limits.full_preset),
            "actuator": limits.actuator,
            "scale": limits.scale,
        },
        "provenance": dict(schedule.provenance),
        "steps": [dict(zip(columns_of(export, version), row, strict=True)) for row in rows],
    }


def schedule_of(document: Document, where: str) -> Schedule:
    """The schedule of a document; ScheduleError naming ``where`` and the place for anything that does not fit.

    Only form is judged here: keys, types, and steps that join. ``emg2vsa.schedules.check`` judges the values.
    """
    _check_keys(document, _HEAD, where)
    if document["format"] != FORMAT or not 1 <= document["version"] <= VERSION:
        found = f"{document['format']} {document['version']}"
        raise ScheduleError(f"{where}, format", wanted=f"{FORMAT} 1 or {VERSION}", found=found, do=EXPORT_AGAIN)
    _check_keys(document["ramp"], _RAMP, f"{where}, ramp")
    export = export_in(document, where)
    _check_keys(document["provenance"], dict.fromkeys(document["provenance"], str), f"{where}, provenance")
    kinds = columns_of(export, document["version"])
    for number, row in enumerate(document["steps"], start=1):
        _check_row(row, document["steps"][number - 2] if number > 1 else None, kinds, f"{where}, row {number}")
    columns = {name: np.array([row[name] for row in document["steps"]], dtype=kind) for name, kind in kinds.items()}
    interval = [columns[name] for name in ("stiffness_low_percent", "stiffness_high_percent") if name in columns]
    limits = _limits(document["limits"], export, f"{where}, limits.stiffness_percent")
    return Schedule(
        specimen=document["specimen"],
        condition=document["condition"],
        step_force_n=np.append(columns["force_from_n"], columns["force_to_n"][-1:]),
        stiffness_percent=columns["stiffness_percent"],
        preset=columns[export.column] / export.per_preset / limits.full_preset,
        stiffness_nm_per_rad=columns["stiffness_nm_per_rad"],
        activity_v=columns["activity_v"],
        last_step_short=document["last_step_short"],
        ramp=Ramp(**{name: float(value) for name, value in document["ramp"].items()}),
        limits=limits,
        provenance=document["provenance"],
        interval_percent=np.stack(interval) if interval else None,
    )


def _check_keys(table: Any, kinds: dict[str, Any], where: str, *, columns: bool = False) -> None:
    """``table`` has these keys, or ``columns``, and values of these kinds."""
    if not isinstance(table, dict) or set(table) != set(kinds):
        wanted = f"the {'columns' if columns else 'keys'} {', '.join(kinds)}"
        found = ", ".join(map(str, table)) if isinstance(table, dict) else _name(table)
        raise ScheduleError(where, wanted=wanted, found=found or "none", do=EXPORT_AGAIN)
    for key, kind in kinds.items():
        if not _is(table[key], kind):
            place = f"{where}, {'column ' * columns}{key}"
            raise ScheduleError(place, wanted=_WORDS[kind], found=_name(table[key]), do=EXPORT_AGAIN)


def export_in(document: Document, where: str) -> Export:
    """How a document states presets, by the actuator of its limits. ScheduleError where that cannot be told."""
    limits = document.get("limits")
    name = limits.get("actuator") if isinstance(limits, dict) else None
    name = name if isinstance(name, str) else joint_names()[0]
    if kind_with(name) is None:
        wanted = f"one of {', '.join(joint_names())}"
        raise ScheduleError(f"{where}, limits.actuator", wanted=wanted, found=repr(name), do=EXPORT_AGAIN)
    export = export_of(name)
    kind = int if export.whole else float
    kinds = {"stiffness_percent": list, export.limit: kind, "actuator": str, "scale": str}
    _check_keys(limits, kinds, f"{where}, limits")
    return export


def _check_row(row: Any, before: dict[str, Any] | None, kinds: Columns, where: str) -> None:
    _check_keys(row, dict(kinds), where, columns=True)
    if before is not None and row["force_from_n"] != before["force_to_n"]:
        wanted = f"{before['force_to_n']}, where the step before ends"
        raise ScheduleError(
            f"{where}, column force_from_n", wanted=wanted, found=str(row["force_from_n"]), do=EXPORT_AGAIN
        )


def _is(value: Any, kind: type) -> bool:
    # true is an int to Python; a whole number may stand where a number is wanted, but within what numpy can hold
    if kind in (int, float):
        whole = isinstance(value, int) and not isinstance(value, bool) and abs(value) < 2**53
        return whole or (kind is float and isinstance(value, float))
    return isinstance(value, kind)


def _name(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 40 else f"{text[:37]}..."


def _limits(table: dict[str, Any], export: Export, where: str) -> Limits:
    pair = table["stiffness_percent"]
    if len(pair) != 2 or not all(_is(value, float) for value in pair):
        raise ScheduleError(where, wanted="two numbers", found=_name(pair), do=EXPORT_AGAIN)
    full_preset = table[export.limit] / export.per_preset
    return Limits((float(pair[0]), float(pair[1])), full_preset, table["actuator"], table["scale"])
