"""What a press on a specimen of known stiffness lets expect: its largest force, and its depth."""

from __future__ import annotations

import math

from emg2vsa.dome_contact import SHEAR_OVER_NORMAL, ElasticDome, PowerLaw
from emg2vsa.rig.executor.witnesses import DEAD_S
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.rig_settings import RigSettings

NOISE_N = 0.05
"""Of the force sensor, at most."""
STIFFENING_S = 0.1
"""How long the motors take to a new stiffness."""
BEYOND_LIMIT = 1.2
"""Of the force limit: a depth at which the specimen would bear so much is too deep."""


def largest_force_n(plan: RunPlan, rig: RigSettings) -> float | None:
    """Largest force along the push axis that a run without a fault may reach, N; None without the specimen's stiffness.

    Above F_max the probe goes on for as long as the filter of the force, a turn of the loop, bus, motors and shaft are
    late; the specimen answers with its stiffness at F_max, and a step of stiffness near F_max adds to the speed.
    """
    if plan.stiffness_n_per_mm is None:
        return None
    contact = ElasticDome().on(plan.stiffness_n_per_mm)
    # a skin that sticks takes a part of the force, and resists the way along the surface too
    slope_n_per_mm = max(_slope(contact, plan, sticks=sticks) for sticks in (False, True))
    # two lags in series, of motors and shaft, go on by less than half the time of the slow motors of the guard
    delay_s = (rig.filter_samples - 1) / 2 * rig.period_s + rig.period_s + DEAD_S + rig.guards.following_s / 2
    speed_mm_per_s = plan.ramp_mm_per_s + _stiffening_mm(plan, rig) / STIFFENING_S
    return plan.f_max_n + slope_n_per_mm * speed_mm_per_s * delay_s + NOISE_N


def most_past_contact_mm(plan: RunPlan, rig: RigSettings) -> float:
    """How far the shaft may go after contact, mm: as deep as the specimen bears a little more than the force limit, and
    never further than the guard says."""
    most_mm = rig.guards.past_contact_mm
    if plan.stiffness_n_per_mm is None:
        return most_mm
    across = math.cos(math.radians(plan.angle_deg))
    contact = ElasticDome().on(plan.stiffness_n_per_mm)
    first_mm, last_mm = (
        contact.depth_mm(force_n / across) / across for force_n in (plan.f_contact_n, BEYOND_LIMIT * rig.guards.force_n)
    )
    return min(most_mm, last_mm - first_mm)


def _slope(contact: PowerLaw, plan: RunPlan, *, sticks: bool) -> float:
    """Growth of the force along the axis at F_max, N/mm."""
    tilt_rad, share = math.radians(plan.angle_deg), SHEAR_OVER_NORMAL * sticks
    along = math.cos(tilt_rad) + share * math.sin(tilt_rad) * math.tan(tilt_rad)
    growth_n_per_mm = contact.resistance(contact.depth_mm(plan.f_max_n / along))[1]
    return growth_n_per_mm * (math.cos(tilt_rad) ** 2 + share * math.sin(tilt_rad) ** 2)


def _stiffening_mm(plan: RunPlan, rig: RigSettings) -> float:
    """By how much the last step of stiffness before F_max, at zero load, bends the joint back."""
    if plan.schedule is None:
        return 0.0
    last = plan.step_at(plan.f_max_n)
    before, after = plan.schedule.stiffness_nm_per_rad[[max(0, last - 1), last]].tolist()
    newton_per_m = 1 / rig.lever_m**2
    return float(max(0.0, 1000 * plan.f_max_n * (1 / before - 1 / after) / newton_per_m))
