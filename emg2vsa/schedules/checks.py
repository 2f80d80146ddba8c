"""The limits every schedule keeps, checked before it is written, after it is read, and before a byte is sent."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from emg2vsa.devices.joints import joint_names, kind_with
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
        schedule.stiffness_percent, schedule.preset, schedule.stiffness_nm_per_rad, schedule.activity_v
    )  # fmt: skip
    columns += () if schedule.interval_percent is None else tuple(schedule.interval_percent)
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
    yield "specimen", bool(schedule.specimen), "a name", repr(schedule.specimen)
    yield "provenance", texts, "only texts", schedule.provenance
    yield "condition", schedule.condition in CONDITIONS, f"one of {', '.join(CONDITIONS)}", schedule.condition
    if kind_with(limits.actuator) is None:
        yield "limits.actuator", False, f"one of {', '.join(joint_names())}", limits.actuator
    yield "limits.scale", limits.scale in ("preset", "stiffness"), "preset or stiffness", limits.scale
    yield "limits.stiffness_percent", 0 <= low < high <= 100, "two rising values from 0 to 100 %", f"{low}, {high}"
    export = limits.export
    top = export.exported(limits.full_preset)
    wanted = f"{'1 to' if export.whole else 'above 0 and at most'} {export.most:g} {export.unit}"
    yield f"limits.{export.limit}", 0 < top <= export.most, wanted, top
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
    limits, percent, joint, export = (
        schedule.limits,
        schedule.stiffness_percent,
        schedule.limits.joint,
        schedule.limits.export,
    )
    activity, stiffness = schedule.activity_v, schedule.stiffness_nm_per_rad
    yield "activity_v", np.isfinite(activity), "a finite number", activity
    yield "stiffness_percent", np.isfinite(percent) & (percent >= 0) & (percent <= 100), "0 to 100 %", percent
    low, high = limits.preset_percent(np.array(limits.stiffness_percent, dtype=np.float64))
    inside = (percent >= low * (1 - _CLOSE)) & (percent <= high * (1 + _CLOSE))
    yield "stiffness_percent", inside, f"{low:.6g} to {high:.6g} %, the study's range", percent
    if schedule.interval_percent is not None:
        least, most = schedule.interval_percent
        wanted = f"{low:.6g} % to stiffness_percent", f"stiffness_percent to {high:.6g} %"
        yield "stiffness_low_percent", (least >= low * (1 - _CLOSE)) & (least <= percent), wanted[0], least
        yield "stiffness_high_percent", (most >= percent) & (most <= high * (1 + _CLOSE)), wanted[1], most
    preset, shown, top = schedule.preset, schedule.exported, export.exported(limits.full_preset)
    within = np.isfinite(preset) & (preset >= 0) & (preset <= 1)
    yield export.column, within, f"0 to {top} {export.unit}, the device's maximum preset", shown
    nearest = joint.rounded(percent / 100)
    # a value halfway between two presets may round either way on another machine
    step = 1 / top if export.whole else 0.0
    agrees = (np.abs(preset - percent / 100) <= step / 2 + _CLOSE) | (np.abs(preset - nearest) <= _CLOSE)
    expected = np.array([export.exported(share * limits.full_preset) for share in nearest.tolist()])
    yield export.column, agrees, _text(expected, agrees, f"the {export.unit} of its percent, {{}}"), shown
    model = joint.stiffness_nm_per_rad(preset)
    right = np.isfinite(stiffness) & (np.abs(stiffness - model) <= _CLOSE * model)
    yield "stiffness_nm_per_rad", right, _text(model, right, f"the stiffness of its {export.unit}, {{}}"), stiffness
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


def _text(expected: NDArray[np.generic], good: NDArray[np.bool_], form: str) -> str:
    return form.format(expected[int(np.argmin(good))])
