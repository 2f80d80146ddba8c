"""Limits and dry run of a plan, before anything is sent."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK
from emg2vsa.errors import InputError
from emg2vsa.rig.executor.plan_limits import check_plan, dry_run
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.rig_settings import RigSettings


@pytest.mark.parametrize(
    ("plan", "rig_changes", "place"),
    [
        ({"repetitions": 0}, {}, "repetitions"),
        ({"angle_deg": 90.0}, {}, "angle_deg"),
        ({"f_max_n": 0.5}, {}, "f_max_n"),
        ({"f_max_n": 10.0}, {}, "f_max_n"),
        ({"f_max_n": 7.5}, {}, "last force step"),
        ({"f_max_n": float("nan")}, {}, "f_max_n"),
        ({"pause_s": -1.0}, {}, "pause_s"),
        ({"ramp_mm_per_s": 0.0}, {}, "ramp_mm_per_s"),
        ({"ramp_mm_per_s": 6.0}, {}, "ramp.speed"),
        ({"ramp_mm_per_s": 41.0, "stiffness_n_per_mm": None}, {}, "ramp_mm_per_s"),
        ({"ramp_mm_per_s": 39.0, "stiffness_n_per_mm": 7.63}, {}, "ramp_mm_per_s"),
        ({}, {"escape_mm_per_s": 41.0}, "escape_mm_per_s"),
        ({"schedule": None}, {}, "schedule"),
        ({"condition": "high-stiffness"}, {}, "stiffness_n_per_mm"),
        ({"specimen": "S9"}, {}, "specimen"),
        ({}, {"travel_mm": 14.0}, "travel_mm"),
        ({}, {"home_deg": 9000 * DEG_PER_TICK}, "position at 15 mm"),
        ({}, {"push_sign": -1, "position_deg": (-6000 * DEG_PER_TICK, 6000 * DEG_PER_TICK)}, "position at 15 mm"),
        ({}, {"gear_mm_per_degree": 0.3}, "ramp.gear"),
        ({}, {"full_preset": 2900 * DEG_PER_TICK}, "stiffness preset"),
        ({}, {"stiffness_percent": (30.0, 80.0)}, "stiffness preset"),
    ],
)
def test_refused(
    plan: dict[str, Any], rig_changes: dict[str, Any], place: str, plan_of: Callable[..., RunPlan], rig: RigSettings
) -> None:
    check_plan(plan_of(), rig)
    with pytest.raises(InputError) as caught:
        check_plan(plan_of(**plan), replace(rig, **rig_changes))
    assert place in caught.value.where


def test_dry_run_tells_positions_stiffness_and_times(plan_of: Callable[..., RunPlan], rig: RigSettings) -> None:
    plan = plan_of(repetitions=10, pause_s=2.0)
    told = dry_run(plan, rig)
    load = [leg for leg in told.legs if leg.phase == "load"]
    assert [leg.preset for leg in load] == plan.schedule.preset.tolist()
    assert np.array([leg.force_n for leg in load])[:, 1] == pytest.approx(plan.schedule.step_force_n[1:])
    assert told.legs[0].position_deg == pytest.approx((0, 75))  # 15 mm at 0.2 mm per degree
    assert told.at_most_s == pytest.approx(10 * (3 + 3 + 0.05 + 2))


def test_dry_run_tells_the_largest_force_where_the_specimen_is_known(
    plan_of: Callable[..., RunPlan], rig: RigSettings
) -> None:
    unknown = dry_run(plan_of(), rig)
    assert (unknown.largest_force_n, unknown.past_contact_mm) == (None, rig.guards.past_contact_mm)
    soft, stiff = (dry_run(plan_of(stiffness_n_per_mm=kappa), rig) for kappa in (1.11, 7.63))
    assert soft.largest_force_n is not None
    assert stiff.largest_force_n is not None
    assert 7.0 < soft.largest_force_n < stiff.largest_force_n < rig.guards.force_n
    assert 0 < stiff.past_contact_mm < soft.past_contact_mm <= rig.guards.past_contact_mm
