from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emg2vsa.errors import SettingError
from emg2vsa.worlds.people.person import check_coefficients, cocontraction_v, logarithm_end

A_V, B_V = 30e-6, 15e-6


def test_equation_6_holds_above_the_joint() -> None:
    force_n = np.linspace(0.3, 9, 500)
    v = cocontraction_v(force_n, A_V, B_V, 0.5)
    np.testing.assert_allclose(v, A_V + B_V * np.log(force_n), rtol=1e-14)


def test_rest_tone_at_zero_force() -> None:
    _, join_v = logarithm_end(A_V, B_V, 0.5)
    assert cocontraction_v(np.zeros(1), A_V, B_V, 0.5)[0] == pytest.approx(0.2 * join_v)


@given(a_v=st.floats(20e-6, 100e-6), b_v=st.floats(1e-6, 14e-6), lower_n=st.floats(0.4, 2.0))
def test_joint_has_no_step_and_no_corner(a_v: float, b_v: float, lower_n: float) -> None:
    join_n, join_v = logarithm_end(a_v, b_v, lower_n)
    step_n = 1e-6 * join_n
    below, at, above = cocontraction_v(join_n + np.array([-step_n, 0, step_n]), a_v, b_v, lower_n)
    assert at == pytest.approx(join_v, rel=1e-12)
    assert (at - below) / step_n == pytest.approx((above - at) / step_n, rel=1e-3)


def test_activity_rises_from_rest_to_peak() -> None:
    v = cocontraction_v(np.linspace(0, 9, 2000), A_V, B_V, 0.5)
    assert np.all(np.diff(v) > 0)


@pytest.mark.parametrize(("a_v", "b_v"), [(30e-6, 0.0), (30e-6, -1e-6), (10e-6, 15e-6)])
def test_impossible_coefficients_are_refused(a_v: float, b_v: float) -> None:
    with pytest.raises(SettingError, match="specimen S1"):
        check_coefficients("specimen S1", a_v, b_v, 0.5)


def test_another_rest_tone_joins_without_a_step_and_levels_may_differ_by_sample() -> None:
    join_n, _ = logarithm_end(A_V, B_V, 0.5)
    force_n = np.array([0.0, join_n * (1 - 1e-9), join_n, 3.0])
    level_v = cocontraction_v(force_n, A_V * np.ones(4), B_V * np.array([1.0, 1.0, 1.0, 2.0]), 0.5, rest_v=1e-6)
    assert level_v == pytest.approx([1e-6, *[A_V + B_V * np.log(join_n)] * 2, A_V + 2 * B_V * np.log(3)], rel=1e-6)
