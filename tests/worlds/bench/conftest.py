"""Plans of every kind, with the schedules they need."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import pytest

from benchmarks.rig.plans import modular_plan, rigid_plan
from emg2vsa.rig.plan import RIGID, Condition, RunPlan


@pytest.fixture(scope="session")
def plan() -> Callable[..., RunPlan]:
    """A plan of a condition; two presses on S3 unless changed."""

    def make(condition: str = "modular", **changes: Any) -> RunPlan:
        changes = {"repetitions": 2, "pause_s": 0.2} | changes
        if condition == RIGID:
            return rigid_plan(**changes)
        return modular_plan(condition=cast(Condition, condition), **changes)

    return make
