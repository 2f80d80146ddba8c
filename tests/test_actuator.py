"""The spring model against the published table, its balance, and its inverse."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emg2vsa.actuator import (
    MOTOR_LIMIT_TICKS,
    RAD_PER_TICK,
    SPRINGS,
    preset_for_stiffness,
    stiffness_at,
    stiffness_nm_per_rad,
    ticks_of_percent,
    unloaded_deflection_rad,
)
from emg2vsa.errors import ScheduleError

TABLE_TICKS = np.array([0, 1000, 2000, 3000, 4000])
MODELS = pytest.mark.parametrize("model", sorted(SPRINGS))


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
    back = preset_for_stiffness(stiffness, model)
    assert stiffness_nm_per_rad(back, model) == pytest.approx(stiffness, rel=1e-12)
    if ticks >= 50:  # below, stiffness is flat in the preset
        assert back == pytest.approx(ticks, rel=1e-12)


@pytest.mark.parametrize("stiffness", [0.01, 1e11, float("nan")])
def test_unreachable_stiffness_is_refused(stiffness: float) -> None:
    with pytest.raises(ScheduleError, match=r"expected 0\.0333 to"):
        preset_for_stiffness([1.0, stiffness], "qbmove-advanced")


def test_percent_and_ticks() -> None:
    np.testing.assert_array_equal(ticks_of_percent([0, 20, 50.01, 80, 100], 3000), [0, 600, 1500, 2400, 3000])


@given(ticks=st.integers(0, MOTOR_LIMIT_TICKS), top=st.integers(1, MOTOR_LIMIT_TICKS))
def test_ticks_survive_percent(ticks: int, top: int) -> None:
    assert ticks_of_percent(100 * ticks / top, top) == ticks
