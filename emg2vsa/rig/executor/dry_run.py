"""What a run would send, without sending it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from emg2vsa.rig.executor.expected import largest_force_n, most_past_contact_mm
from emg2vsa.rig.executor.plan_limits import check_plan
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.rig_settings import RigSettings


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
