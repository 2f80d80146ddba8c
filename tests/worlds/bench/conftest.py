"""Plans of every kind, with the schedules they need."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, cast

import numpy as np
import pytest

from emg2vsa.profiles import Profile, Profiles
from emg2vsa.rig.plan import RIGID, Condition, RunPlan
from emg2vsa.schedules import Schedule
from emg2vsa.schedules.build import build_schedules
from emg2vsa.settings import ScheduleSettings


def _schedule(specimen: str, condition: Any) -> Schedule:
    force = np.linspace(0.5, 7, 100)
    v = 42e-6 + 20e-6 * np.log(force)
    profile = Profile(specimen, 5.0, 42e-6, 20e-6, force, v, "measured", 10, np.full(100, np.nan))
    profiles = Profiles(
        profiles=(profile,), new=None, weight_alpha=math.nan, bracket=None, new_measured=None, new_error=None,
        leave_one_out=(), participant="", unit="V", notes=(),
    )  # fmt: skip
    (schedule,) = build_schedules(profiles, ScheduleSettings(conditions=(condition,)), {"study": "palpation"})
    return schedule


@pytest.fixture(scope="session")
def plan() -> Callable[..., RunPlan]:
    """A plan of a condition; two presses on S3 unless changed."""

    def make(condition: str = "modular", **changes: Any) -> RunPlan:
        values: dict[str, Any] = {
            "specimen": "S3", "angle_deg": 0.0, "repetitions": 2, "f_max_n": 7.0, "pause_s": 0.2,
        } | changes  # fmt: skip
        schedule = None if condition == RIGID else _schedule(values["specimen"], condition)
        return RunPlan(condition=cast(Condition, condition), schedule=schedule, **values)

    return make
