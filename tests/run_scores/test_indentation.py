"""The kinesthetic cue of a press."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.run_scores.press import indentation_slope

STEP_MM = 360 / 4096 * 0.2  # of the encoder through the gear


def test_slope_of_a_linear_press_in_spite_of_the_encoders_steps():
    depth = np.arange(0, 3, 0.025)
    force = 2.5 * depth
    slope = indentation_slope(force, np.round((4 + depth) / STEP_MM) * STEP_MM, from_n=0.5)
    assert slope == pytest.approx(2.5, rel=5e-3)


def test_without_a_log_or_a_way_in_there_is_no_slope():
    assert np.isnan(indentation_slope(np.empty(0), np.empty(0), 0.5))
    force = np.linspace(0, 7, 50)
    assert np.isnan(indentation_slope(force, np.full(50, 2.0), 0.5))
    assert np.isnan(indentation_slope(np.full(50, 0.1), np.linspace(0, 1, 50), 0.5))
