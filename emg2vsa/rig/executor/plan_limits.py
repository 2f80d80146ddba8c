"""May this rig do this plan? Asked before any byte is sent; nothing is clipped to fit."""

from __future__ import annotations

import math
from collections.abc import Iterator

from emg2vsa.devices.joints import joint_of
from emg2vsa.devices.protocols import Rating
from emg2vsa.errors import ScheduleError, SettingError
from emg2vsa.rig.executor.expected import largest_force_n
from emg2vsa.rig.plan import RIGID, RunPlan
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.schedules import CONDITIONS, Schedule, check

_ROUNDED = 1e-9
"""Share of the full preset that rounding may make."""
Rule = tuple[str, bool, str, object]


def check_plan(plan: RunPlan, rig: RigSettings) -> None:
    """SettingError or ScheduleError at the first thing that does not make sense or that the rig must not do."""
    for name, holds, wanted, found in _plan_rules(plan, rig):
        if not holds:
            raise SettingError(f"plan, {name}", wanted=wanted, found=str(found), do="Correct the plan or rig.toml.")
    if plan.schedule is not None:
        check(plan.schedule)
        where = f"schedule of {plan.schedule.specimen}, {plan.schedule.condition}"
        for name, holds, wanted, found in _schedule_rules(plan, plan.schedule, rig):
            if not holds:
                do = "Export the schedule for this rig, or choose the one that belongs to the plan."
                raise ScheduleError(f"{where}, {name}", wanted=wanted, found=str(found), do=do)


def is_count(value: object) -> bool:
    """A whole number from 1."""
    return isinstance(value, int) and not isinstance(value, bool) and value >= 1


def check_rating(rig: RigSettings, rating: Rating | None) -> None:
    """SettingError where the force limit lies beyond what the force sensor is made for."""
    if rating is None:
        return
    shares = zip(map(abs, rig.push_axis), rating.force_n, strict=True)
    most_n = min(most / share for share, most in shares if share > 0)
    if rig.guards.force_n > most_n:
        wanted, do = f"at most {most_n:g} N, the rating of the force sensor along push_axis", "Correct the rig file."
        raise SettingError("rig.guards.force_n", wanted=wanted, found=f"{rig.guards.force_n:g} N", do=do)


def _plan_rules(plan: RunPlan, rig: RigSettings) -> Iterator[Rule]:
    yield "specimen", bool(plan.specimen), "a name", repr(plan.specimen)
    yield "angle_deg", 0 <= plan.angle_deg < 90, "0 to below 90 degrees", plan.angle_deg
    yield (
        "condition",
        plan.condition in (RIGID, *CONDITIONS),
        f"one of {', '.join((RIGID, *CONDITIONS))}",
        plan.condition,
    )
    rigid = plan.condition == RIGID
    given = "a schedule" if plan.schedule else "no schedule"
    yield "schedule", rigid == (plan.schedule is None), "no schedule" if rigid else "a schedule", given
    yield "repetitions", is_count(plan.repetitions), "a whole number from 1", plan.repetitions
    for name, value in (
        ("ramp_mm_per_s", plan.ramp_mm_per_s), ("travel_mm", plan.travel_mm), ("f_contact_n", plan.f_contact_n)
    ):  # fmt: skip
        yield name, 0 < value < math.inf, "a number above 0", value
    for name, value in (("ramp_mm_per_s", plan.ramp_mm_per_s), ("rig's escape_mm_per_s", rig.escape_mm_per_s)):
        yield name, value <= rig.max_mm_per_s, f"at most rig.max_mm_per_s, {rig.max_mm_per_s:g}", value
    for name, value in (("pause_s", plan.pause_s), ("contact_s", plan.contact_s), ("lead_s", plan.lead_s)):
        yield name, 0 <= value < math.inf, "0 s or more", value
    low, high = plan.f_contact_n, rig.guards.force_n
    yield (
        "f_max_n",
        low < plan.f_max_n < high,
        f"above contact, {low:g} N, and below the guard, {high:g} N",
        plan.f_max_n,
    )
    most_n = largest_force_n(plan, rig) if low < plan.f_max_n < high and 0 <= plan.angle_deg < 90 else None
    yield (
        "ramp_mm_per_s",
        most_n is None or most_n <= high,
        f"a speed at which the force overshoots to at most the guard, {high:g} N",
        f"{plan.ramp_mm_per_s:g}, which lets expect {most_n or 0:.1f} N",
    )
    yield "travel_mm", plan.travel_mm <= rig.travel_mm, f"at most {rig.travel_mm:g} mm, the rig's", plan.travel_mm
    low_deg, high_deg = rig.position_deg
    wanted = f"{low_deg:.6g} to {high_deg:.6g} degrees, the device's"
    for depth_mm in (0.0, plan.travel_mm):
        position_deg = rig.position_at(depth_mm)
        yield f"position at {depth_mm:g} mm", low_deg <= position_deg <= high_deg, wanted, f"{position_deg:.6g}"


def _schedule_rules(plan: RunPlan, schedule: Schedule, rig: RigSettings) -> Iterator[Rule]:
    own = plan.schedule_from or plan.specimen
    yield "specimen", schedule.specimen == own, own, schedule.specimen
    yield "condition", schedule.condition == plan.condition, plan.condition, schedule.condition
    for name, wanted, found in (
        ("ramp.gear_mm_per_degree", rig.gear_mm_per_degree, schedule.ramp.gear_mm_per_degree),
        ("ramp.speed_mm_per_s", plan.ramp_mm_per_s, schedule.ramp.speed_mm_per_s),
        ("ramp.travel_mm", plan.travel_mm, schedule.ramp.travel_mm),
    ):
        yield name, math.isclose(wanted, found), f"{wanted:g}, as on the rig and in the plan", found
    last_n = float(schedule.step_force_n[-1])
    yield "last force step", plan.f_max_n <= last_n * (1 + 1e-9), f"steps up to F_max, {plan.f_max_n:g} N", last_n
    joint = joint_of(schedule.limits.actuator, rig.full_preset)
    low, high = joint.rounded([percent / 100 for percent in rig.stiffness_percent]).tolist()
    text = f"{100 * low:.6g} to {100 * high:.6g} % of the device's maximum"
    presets = plan.presets(rig.full_preset)
    for preset in (min(presets), max(presets)):
        yield "stiffness preset", low - _ROUNDED <= preset <= high + _ROUNDED, text, f"{100 * preset:.6g} %"
