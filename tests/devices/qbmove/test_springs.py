"""The spring model against the published table, its balance, and its inverse."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats
from emg2vsa.devices.protocols import Measurements
from emg2vsa.devices.qbmove.springs import (
    EXPORT,
    MOTOR_LIMIT_TICKS,
    RAD_PER_TICK,
    SPRINGS,
    SpringJoint,
    stiffness_at,
    unloaded_deflection_rad,
)
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK
from emg2vsa.errors import ScheduleError

FULL_TICKS = 3000
TABLE_TICKS = np.array([0, 1000, 2000, 3000, 4000])
MODELS = pytest.mark.parametrize("model", sorted(SPRINGS))


def joint_of(model: str, full_ticks: int = FULL_TICKS) -> SpringJoint:
    return SpringJoint(model, full_ticks * DEG_PER_TICK)


def stiffness_nm_per_rad(ticks: ArrayLike, model: str) -> Floats:
    return joint_of(model).stiffness_nm_per_rad(np.asarray(ticks) / FULL_TICKS)


@pytest.mark.parametrize(
    ("model", "published"),
    [
        ("qbmove-advanced", [0.0333, 0.0965, 0.5256, 2.949, 16.56]),
        ("qbmove-maker-pro", [0.3032, 0.6042, 2.106, 7.797, 29.01]),
    ],
)
def test_table_midway_between_the_motors(model: str, published: list[float]) -> None:
    preset = TABLE_TICKS * RAD_PER_TICK
    np.testing.assert_allclose(stiffness_at(np.zeros(5), preset, SPRINGS[model]), published, rtol=5e-4)


def test_table_of_the_advanced_at_its_true_equilibrium() -> None:
    published = [0.0333, 0.0892, 0.4806, 2.695, 15.14]
    np.testing.assert_allclose(stiffness_nm_per_rad(TABLE_TICKS, "qbmove-advanced"), published, rtol=6e-4)


def test_units_of_the_tick() -> None:
    assert pytest.approx(math.radians(32.96), rel=1e-4) == 3000 * RAD_PER_TICK
    assert pytest.approx(math.radians(164.79), rel=1e-4) == MOTOR_LIMIT_TICKS * RAD_PER_TICK


def test_equilibrium_shifts_by_the_logarithm_of_the_spring_ratio() -> None:
    springs = SPRINGS["qbmove-advanced"]
    limit = math.log(springs.k1_nm / springs.k2_nm) / (springs.a1_per_rad + springs.a2_per_rad)
    assert limit == pytest.approx(0.0478, abs=5e-5)
    assert unloaded_deflection_rad(np.array([3000 * RAD_PER_TICK]), springs)[0] == pytest.approx(limit, abs=1e-4)


@MODELS
def test_no_torque_and_no_slope_error_at_zero_load(model: str) -> None:
    springs = SPRINGS[model]
    preset = np.linspace(0, MOTOR_LIMIT_TICKS, 501) * RAD_PER_TICK
    deflection = unloaded_deflection_rad(preset, springs)
    torque = springs.k1_nm * np.sinh(springs.a1_per_rad * (deflection - preset)) + springs.k2_nm * np.sinh(
        springs.a2_per_rad * (deflection + preset)
    )
    stiffness = stiffness_at(deflection, preset, springs)
    assert np.max(np.abs(torque) / stiffness) < 2e-15  # rad of shaft angle


@MODELS
@pytest.mark.parametrize("ticks", [0.0, 500.0, 3000.0])
def test_stiffness_is_the_slope_of_torque(model: str, ticks: float) -> None:
    springs, s, h = SPRINGS[model], ticks * RAD_PER_TICK, 1e-5

    def torque(x: float) -> float:
        return springs.k1_nm * math.sinh(springs.a1_per_rad * (x - s)) + springs.k2_nm * math.sinh(
            springs.a2_per_rad * (x + s)
        )

    x = float(unloaded_deflection_rad(np.array([s]), springs)[0])
    slope = (torque(x + h) - torque(x - h)) / (2 * h)
    assert stiffness_nm_per_rad(ticks, model) == pytest.approx(slope, rel=1e-7)


@MODELS
def test_stiffness_rises_with_preset_and_ignores_its_sign(model: str) -> None:
    ticks = np.arange(0, MOTOR_LIMIT_TICKS + 1, 50)
    stiffness = stiffness_nm_per_rad(ticks, model)
    assert np.all(np.diff(stiffness) > 0)
    np.testing.assert_array_equal(stiffness_nm_per_rad(-ticks, model), stiffness)


@MODELS
@given(ticks=st.floats(0, MOTOR_LIMIT_TICKS))
def test_inverse(model: str, ticks: float) -> None:
    stiffness = stiffness_nm_per_rad(ticks, model)
    back = joint_of(model).percent_for(stiffness) / 100 * FULL_TICKS
    assert stiffness_nm_per_rad(back, model) == pytest.approx(stiffness, rel=1e-12)
    if ticks >= 50:  # below, stiffness is flat in the preset
        assert back == pytest.approx(ticks, rel=1e-12)


@pytest.mark.parametrize("stiffness", [0.01, 1e11, float("nan")])
def test_unreachable_stiffness_is_refused(stiffness: float) -> None:
    with pytest.raises(ScheduleError, match=r"expected 0\.0333 to"):
        joint_of("qbmove-advanced").percent_for([1.0, stiffness])


def test_presets_are_rounded_to_whole_ticks() -> None:
    rounded = joint_of("qbmove-maker-pro").rounded(np.array([0, 20, 50.01, 80, 100]) / 100)
    np.testing.assert_array_equal(rounded * FULL_TICKS, [0, 600, 1500, 2400, 3000])


@given(ticks=st.integers(0, MOTOR_LIMIT_TICKS), top=st.integers(1, MOTOR_LIMIT_TICKS))
def test_ticks_survive_percent(ticks: int, top: int) -> None:
    joint = joint_of("qbmove-advanced", top)
    preset = float(joint.rounded(100 * ticks / top / 100))
    assert EXPORT.exported(preset * joint.full_preset) == ticks
    assert float(joint.preset_rad(preset)) == ticks * RAD_PER_TICK


@MODELS
@given(position=st.integers(-12000, 12000), ticks=st.integers(0, 3000), shaft=st.integers(-16384, 16384))
def test_equation_8_both_ways(model: str, position: int, ticks: int, shaft: int) -> None:
    joint = joint_of(model)
    targets_deg = joint.targets_deg(position * DEG_PER_TICK, ticks / FULL_TICKS)
    expected_ticks = position + ticks, position - ticks
    assert tuple(angle_deg / DEG_PER_TICK for angle_deg in targets_deg) == pytest.approx(expected_ticks)
    at = Measurements(targets_deg, shaft * DEG_PER_TICK)
    assert joint.position_deg(at) / DEG_PER_TICK == pytest.approx(position, abs=1e-9)
    assert joint.preset_at(at) * FULL_TICKS == pytest.approx(ticks, abs=1e-9)


@MODELS
@pytest.mark.parametrize("command", [(0.0, 0.0), (30.0, 0.8)])
def test_torque_is_that_of_both_springs_whatever_is_commanded(model: str, command: tuple[float, float]) -> None:
    springs, at = SPRINGS[model], Measurements((20.0, -10.0), 8.0)
    by_hand = springs.k1_nm * math.sinh(springs.a1_per_rad * math.radians(-12.0)) + springs.k2_nm * math.sinh(
        springs.a2_per_rad * math.radians(18.0)
    )
    assert joint_of(model).torque_nm(at, *command) == pytest.approx(by_hand, rel=1e-12)


def test_encoders_without_their_turns_give_a_torque_all_the_same() -> None:
    assert math.isfinite(joint_of("qbmove-maker-pro").torque_nm(Measurements((1e6, -1e6), 0.0)))
