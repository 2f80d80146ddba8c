"""What the benchmarks of the rig press."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from casr.specimens import SPECIMENS
from emg2vsa.devices.dynamixel import DynamixelSettings
from emg2vsa.profiles import Profile, Profiles
from emg2vsa.rig.plan import RIGID, Condition, RunPlan
from emg2vsa.schedules import Schedule
from emg2vsa.schedules.build import build_schedules
from emg2vsa.settings import ScheduleSettings

SPECIMEN = "S3"
CONTACT_N, F_MAX_N = 0.5, 7.0


def modular_plan(
    repetitions: int, *, specimen: str = SPECIMEN, condition: Condition = "modular", **changes: Any
) -> RunPlan:
    """Presses up to the paper's F_max, stiffer with every force step; ``changes`` to `RunPlan`."""
    return _plan(repetitions, specimen, condition, changes)


def rigid_plan(repetitions: int, *, specimen: str = SPECIMEN, **changes: Any) -> RunPlan:
    """The same under the rigid motor."""
    return _plan(repetitions, specimen, RIGID, changes)


def dynamixel_plan(
    actuator: DynamixelSettings, gear_mm_per_degree: float, repetitions: int, specimen: str, **changes: Any
) -> RunPlan:
    """As `modular_plan`, with this motor behind this gear."""
    assert actuator.full_stiffness_nm_per_rad
    settings = ScheduleSettings(
        conditions=("modular",), actuator="dynamixel", full_stiffness_nm_per_rad=actuator.full_stiffness_nm_per_rad,
        gear_mm_per_degree=gear_mm_per_degree,
    )  # fmt: skip
    plan = RunPlan(specimen, 0.0, "modular", repetitions, _built(specimen, settings), F_MAX_N)
    return replace(plan, stiffness_n_per_mm=SPECIMENS[specimen], **changes)


def _plan(repetitions: int, specimen: str, condition: Condition, changes: dict[str, Any]) -> RunPlan:
    schedule = None if condition == RIGID else _schedule(specimen, condition)
    known = SPECIMENS[specimen]
    plan = RunPlan(specimen, 0.0, condition, repetitions, schedule, F_MAX_N, stiffness_n_per_mm=known)
    return replace(plan, **changes)


def _schedule(specimen: str, condition: Any) -> Schedule:
    return _built(specimen, ScheduleSettings(conditions=(condition,)))


@cache
def _built(specimen: str, settings: ScheduleSettings) -> Schedule:
    force = np.linspace(CONTACT_N, F_MAX_N, 100)
    v = 42e-6 + 20e-6 * np.log(force)
    rate = SPECIMENS[specimen]
    profile = Profile(specimen, rate, 42e-6, 20e-6, force, v, "measured", 10, np.full(100, np.nan))
    profiles = Profiles(
        profiles=(profile,), new=None, weight_alpha=math.nan, bracket=None, new_measured=None, new_error=None,
        leave_one_out=(), participant="", unit="V", notes=(),
    )  # fmt: skip
    (schedule,) = build_schedules(profiles, settings, {"study": "palpation"})
    return schedule
