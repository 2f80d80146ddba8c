"""May this rig do this plan, what does it let expect, and what would be sent? Asked before any byte is sent; nothing is
clipped to fit."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from emg2vsa.devices.joints import joint_of
from emg2vsa.devices.protocols import Rating
from emg2vsa.dome_contact import SHEAR_OVER_NORMAL, ElasticDome, PowerLaw
from emg2vsa.errors import ScheduleError, SettingError
from emg2vsa.rig.executor.witnesses import DEAD_S
from emg2vsa.rig.plan import RIGID, RunPlan
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.schedules import CONDITIONS, Schedule, check

_NOISE_N = 0.05
"""Largest noise of the force sensor."""
_STIFFENING_S = 0.1
"""How long the motors take to a new stiffness."""
_BEYOND_LIMIT = 1.2
"""Share of the force limit: a depth at which the specimen would bear so much is too deep."""
UNWITNESSED_N = 2.0
"""Largest F_max of a rigid motor on a specimen of unknown stiffness, whose force has no second witness."""
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
    yield from _force_rules(plan, rig)
    yield from _travel_rules(plan, rig)


def _force_rules(plan: RunPlan, rig: RigSettings) -> Iterator[Rule]:
    yield (
        "stiffness_n_per_mm",
        plan.witnessed or plan.plate or plan.f_max_n <= UNWITNESSED_N,
        f"that of the specimen, where a rigid motor presses with more than {UNWITNESSED_N:g} N: nothing else tells a "
        "wrong force; press it with the plate first, or a reference with emg2vsa rig commission --motor --reference",
        "none",
    )
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


def _travel_rules(plan: RunPlan, rig: RigSettings) -> Iterator[Rule]:
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


def largest_force_n(plan: RunPlan, rig: RigSettings) -> float | None:
    """Largest force along the push axis that a run without a fault may reach, N; None without the specimen's stiffness.

    Above F_max the probe goes on for as long as the filter of the force, a turn of the loop, bus, motors and shaft are
    late; the specimen answers with its stiffness at F_max, and a step of stiffness near F_max adds to the speed.
    """
    if plan.stiffness_n_per_mm is None:
        return None
    contact = ElasticDome(sensor_modulus_mpa=rig.dome_modulus_mpa).on(plan.stiffness_n_per_mm)
    # a skin that sticks takes a part of the force, and resists the way along the surface too
    slope_n_per_mm = max(_slope(contact, plan, sticks=sticks) for sticks in (False, True))
    # two lags in series, of motors and shaft, go on by less than half the time of the slow motors of the guard
    delay_s = (rig.filter_samples - 1) / 2 * rig.period_s + rig.period_s + DEAD_S + rig.guards.following_s / 2
    speed_mm_per_s = plan.ramp_mm_per_s + _stiffening_mm(plan, rig) / _STIFFENING_S
    return plan.f_max_n + slope_n_per_mm * speed_mm_per_s * delay_s + _NOISE_N


def most_past_contact_mm(plan: RunPlan, rig: RigSettings) -> float:
    """How far the shaft may go after contact, mm: as deep as the specimen bears a little more than the force limit, and
    never further than the guard says."""
    most_mm = rig.guards.past_contact_mm
    if plan.stiffness_n_per_mm is None:
        return most_mm
    across = math.cos(math.radians(plan.angle_deg))
    contact = ElasticDome(sensor_modulus_mpa=rig.dome_modulus_mpa).on(plan.stiffness_n_per_mm)
    between_n = plan.f_contact_n, _BEYOND_LIMIT * rig.guards.force_n
    first_mm, last_mm = (contact.depth_mm(force_n / across) / across for force_n in between_n)
    return min(most_mm, last_mm - first_mm)


def _slope(contact: PowerLaw, plan: RunPlan, *, sticks: bool) -> float:
    """Growth of the force along the axis at F_max, N/mm."""
    tilt_rad, share = math.radians(plan.angle_deg), SHEAR_OVER_NORMAL * sticks
    along = math.cos(tilt_rad) + share * math.sin(tilt_rad) * math.tan(tilt_rad)
    growth_n_per_mm = contact.resistance(contact.depth_mm(plan.f_max_n / along))[1]
    return growth_n_per_mm * (math.cos(tilt_rad) ** 2 + share * math.sin(tilt_rad) ** 2)


def _stiffening_mm(plan: RunPlan, rig: RigSettings) -> float:
    """Way by which the last step of stiffness before F_max bends the joint back at zero load."""
    if plan.schedule is None:
        return 0.0
    last = plan.step_at(plan.f_max_n)
    before, after = plan.schedule.stiffness_nm_per_rad[[max(0, last - 1), last]].tolist()
    newton_per_m = 1 / rig.lever_m**2
    return float(max(0.0, 1000 * plan.f_max_n * (1 / before - 1 / after) / newton_per_m))


@dataclass(frozen=True)
class Leg:
    """One part of a repetition: a ramp from one position to another, or a rest, at one stiffness.

    Where contact comes, and how deep each force step lies, is the specimen's to say: approach and load may each take
    the whole ramp, so ``position_deg`` are bounds and ``at_most_s`` the longest time.
    """

    phase: str
    position_deg: tuple[float, float]
    preset: float
    "Share of the full preset."
    force_n: tuple[float, float] | None
    "Measured force between which the leg holds; None where force does not matter."
    at_most_s: float


@dataclass(frozen=True)
class DryRun:
    """A repetition as ``legs``, and how long all repetitions may take, without the way home before the first."""

    legs: tuple[Leg, ...]
    repetitions: int
    at_most_s: float
    largest_force_n: float | None
    "To be expected, along the push axis; None where the stiffness of the specimen is not known."
    past_contact_mm: float
    "How far the probe may go after contact before a guard ends the run."


def dry_run(plan: RunPlan, rig: RigSettings) -> DryRun:
    """The plan in positions, presets and durations; SettingError or ScheduleError as ``check_plan``."""
    check_plan(plan, rig)
    home, deep, full = rig.position_at(0.0), rig.position_at(plan.travel_mm), rig.full_preset
    ramp_s = plan.travel_mm / plan.ramp_mm_per_s
    first, last = plan.preset(plan.step_at(0.0), full), plan.preset(plan.step_at(plan.f_max_n), full)
    load = tuple(
        Leg("load", (home, deep), plan.preset(plan.step_at(low), full), (low, high), ramp_s)
        for low, high in _steps_n(plan)
    )
    legs = (
        Leg("approach", (home, deep), first, (0.0, plan.f_contact_n), ramp_s),
        Leg("contact", (home, deep), first, (plan.f_contact_n, plan.f_max_n), plan.contact_s),
        *load,
        Leg("retract", (deep, home), last, None, ramp_s),
        Leg("pause", (home, home), first, None, plan.pause_s),
    )
    # approach and load share one ramp
    once_s = 2 * ramp_s + plan.contact_s + plan.pause_s
    return DryRun(
        legs, plan.repetitions, plan.repetitions * once_s, largest_force_n(plan, rig), most_past_contact_mm(plan, rig)
    )


def _steps_n(plan: RunPlan) -> list[tuple[float, float]]:
    inner = [] if plan.schedule is None else plan.schedule.step_force_n[1:-1].tolist()
    edges = [plan.f_contact_n, *(edge for edge in inner if plan.f_contact_n < edge < plan.f_max_n), plan.f_max_n]
    return list(pairwise(edges))
