"""Travel of the indenter for each newton."""

from __future__ import annotations

import numpy as np
import pytest

from casr.frames import TravelReadings, travel_per_newton

STEP_MM = 360 / 4096 * 0.2  # of an encoder through a gear


def test_slope_of_a_linear_press_in_spite_of_the_encoders_steps():
    depth = np.arange(0, 3, 0.025)
    mm_per_n = travel_per_newton(2.5 * depth, np.round((4 + depth) / STEP_MM) * STEP_MM, from_n=0.5)
    assert mm_per_n == pytest.approx(0.4, rel=5e-3)


def test_without_a_log_or_a_way_in_there_is_no_slope():
    assert np.isnan(travel_per_newton(np.empty(0), np.empty(0), 0.5))
    force = np.linspace(0, 7, 50)
    assert np.isnan(travel_per_newton(force, np.full(50, 2.0), 0.5))
    assert np.isnan(travel_per_newton(force, -force, 0.5))
    assert np.isnan(travel_per_newton(np.full(50, 0.1), np.linspace(0, 1, 50), 0.5))


@pytest.mark.parametrize("peak_n", [4.0, 7.0, 9.0])
def test_of_a_log_the_loading_alone_counts_and_presses_to_other_forces_compare(peak_n):
    """It moves in the air, presses, creeps and goes back."""
    force = np.concatenate(
        [np.full(30, 0.0), np.linspace(0, peak_n, 200), np.full(20, peak_n), np.linspace(peak_n, 0, 50)]
    )
    travel = 40 + force**0.57
    travel[:30] -= np.linspace(3, 0, 30)
    travel[232:] += 1.0
    travel[60] = np.nan
    readings = TravelReadings(travel, 0.2 + force, np.arange(force.size) // 5)
    usual = TravelReadings(np.linspace(0, 7, 300) ** 0.57, np.linspace(0, 7, 300), np.arange(300) // 5)
    assert readings.per_newton(2, 0.5, 7.0, 0.2) == pytest.approx(usual.per_newton(0, 0.5, np.inf, 0.0), rel=5e-3)
    assert np.isnan(readings.per_newton(2, 10.0, np.inf, 0.2))
