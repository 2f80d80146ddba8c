"""The limits every schedule keeps, checked before it is written, after it is read, and before a byte is sent."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from emg2vsa.actuator import MOTOR_LIMIT_TICKS, SPRINGS, stiffness_nm_per_rad, ticks_of_percent
from emg2vsa.arrays import Floats
from emg2vsa.errors import ScheduleError
from emg2vsa.schedules.schedule import CONDITIONS, Schedule, step_tolerance_n

_CLOSE = 1e-9
"""Relative difference that another machine's mathematical library may make."""
EXPORT_AGAIN = "Export the schedule again from its study; do not edit it by hand."
_MEND = "Correct the [schedule] table of the study."
Rule = tuple[str, NDArray[np.bool_], str, NDArray[np.generic]]


def check(schedule: Schedule, where: str = "", do: str = _MEND) -> None:
    """ScheduleError at the first value that breaks a limit: ``where`` (a file), row and column, and what to ``do``.

    Rows count from 1, one per force step.
    """
    where = where or f"schedule of {schedule.specimen}, {schedule.condition}"
    _check_shapes(schedule, where, do)
    for name, holds, wanted, found in _head_rules(schedule):
        if not holds:
            raise ScheduleError(f"{where}, {name}", wanted=wanted, found=str(found), do=do)
    for column, good, wanted, values in _row_rules(schedule):
        if not np.all(good):
            row = int(np.flatnonzero(~good)[0])
            raise ScheduleError(
                f"{where}, row {row + 1}, column {column}", wanted=wanted, found=str(values[row]), do=do
            )


def _check_shapes(schedule: Schedule, where: str, do: str) -> None:
    steps = schedule.step_force_n.size - 1
    columns = (
        schedule.stiffness_percent, schedule.preset_ticks, schedule.stiffness_nm_per_rad, schedule.activity_v
    )  # fmt: skip
    if steps < 1 or any(column.shape != (steps,) for column in columns):
        sizes = ", ".join(str(column.size) for column in columns)
        raise ScheduleError(
            f"{where}, steps", wanted="at least one force step, and one value for each in every column",
            found=f"{max(steps, 0)} steps and {sizes} values", do=do,
        )  # fmt: skip


def _head_rules(schedule: Schedule) -> Iterator[tuple[str, bool, str, object]]:
    limits, ramp = schedule.limits, schedule.ramp
    texts = all(isinstance(text, str) for item in schedule.provenance.items() for text in item)
    low, high = limits.stiffness_percent
    top = limits.max_preset_ticks
    yield "specimen", bool(schedule.specimen), "a name", repr(schedule.specimen)
    yield "provenance", texts, "only texts", schedule.provenance
    yield "condition", schedule.condition in CONDITIONS, f"one of {', '.join(CONDITIONS)}", schedule.condition
    yield "limits.actuator", limits.actuator in SPRINGS, f"one of {', '.join(SPRINGS)}", limits.actuator
    yield "limits.scale", limits.scale in ("preset", "stiffness"), "preset or stiffness", limits.scale
    yield "limits.stiffness_percent", 0 <= low < high <= 100, "two rising values from 0 to 100 %", f"{low}, {high}"
    yield "limits.max_preset_ticks", 0 < top <= MOTOR_LIMIT_TICKS, f"1 to {MOTOR_LIMIT_TICKS} ticks", top
    for name in ("speed_mm_per_s", "gear_mm_per_degree", "travel_mm"):
        value = getattr(ramp, name)
        yield f"ramp.{name}", bool(np.isfinite(value) and value > 0), "a positive number", value
    degrees, seconds = ramp.speed_mm_per_s / ramp.gear_mm_per_degree, ramp.travel_mm / ramp.speed_mm_per_s
    yield (
        "ramp.speed_deg_per_s",
        _close(ramp.speed_deg_per_s, degrees),
        f"speed over gear, {degrees}",
        ramp.speed_deg_per_s,
    )
    yield "ramp.duration_s", _close(ramp.duration_s, seconds), f"travel over speed, {seconds}", ramp.duration_s


def _row_rules(schedule: Schedule) -> Iterator[Rule]:
    yield from _force_rules(schedule)
    limits, percent, ticks = schedule.limits, schedule.stiffness_percent, schedule.preset_ticks
    activity, stiffness = schedule.activity_v, schedule.stiffness_nm_per_rad
    yield "activity_v", np.isfinite(activity), "a finite number", activity
    yield "stiffness_percent", np.isfinite(percent) & (percent >= 0) & (percent <= 100), "0 to 100 %", percent
    low, high = limits.preset_percent(np.array(limits.stiffness_percent, dtype=np.float64))
    inside = (percent >= low * (1 - _CLOSE)) & (percent <= high * (1 + _CLOSE))
    yield "stiffness_percent", inside, f"{low:.6g} to {high:.6g} %, the study's range", percent
    top = limits.max_preset_ticks
    yield "preset_ticks", (ticks >= 0) & (ticks <= top), f"0 to {top} ticks, the device's maximum preset", ticks
    expected = ticks_of_percent(percent, top)
    # a value halfway between two ticks may round either way on another machine
    agrees = np.abs(ticks - percent / 100 * top) <= 0.5 + _CLOSE * top
    yield "preset_ticks", agrees, _text(expected, agrees, "the ticks of its percent, {}"), ticks
    springs = stiffness_nm_per_rad(ticks, limits.actuator)
    right = np.isfinite(stiffness) & (np.abs(stiffness - springs) <= _CLOSE * springs)
    yield "stiffness_nm_per_rad", right, _text(springs, right, "the stiffness of its ticks, {}"), stiffness
    if schedule.condition != "modular":
        yield "stiffness_percent", percent == percent[0], f"{percent[0]}, as in row 1: it is constant", percent


def _force_rules(schedule: Schedule) -> Iterator[Rule]:
    edges = schedule.step_force_n
    low, high = edges[:-1], edges[1:]
    yield "force_from_n", np.isfinite(low) & (low > 0), "a finite force above 0 N", low
    yield "force_to_n", np.isfinite(high) & (high > low), "a finite force above force_from_n", high
    widths = high - low
    like_first = np.abs(widths - widths[0]) <= step_tolerance_n(widths[0])
    if widths.size > 1 and schedule.last_step_short:
        like_first[-1] = widths[-1] < widths[0]
    wanted = f"a step of {widths[0]:.6g} N" + (", and a shorter last one" if schedule.last_step_short else "")
    yield "force_to_n", like_first, wanted, high


def _close(value: float, expected: float) -> bool:
    return bool(abs(value - expected) <= _CLOSE * abs(expected))


def _text(expected: Floats | NDArray[np.int64], good: NDArray[np.bool_], form: str) -> str:
    return form.format(expected[int(np.argmin(good))])
