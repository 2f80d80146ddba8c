"""The mean rate on a power law of area over force."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from casr.errors import FramesError
from casr.spread import PowerLaw, spread_rate
from casr.spread.correlated_errors import student_quantile


def rate_of(area_of, force, **options):
    return spread_rate(area_of(force), force, **options)


def few_frames(rng, n=8):
    """Frames of a fast press: the first lies from 0.5 to 0.8 N, the last from 6.2 to 7.2 N."""
    first, last = rng.uniform(0.5, 0.8), rng.uniform(6.2, 7.2)
    return first + (last - first) * np.linspace(0, 1, n) ** rng.uniform(1, 1.6)


@given(st.floats(0.2, 1.0), st.floats(1, 100), st.integers(2, 40))
def test_a_power_of_force_has_its_exact_mean_rate_wherever_its_frames_lie(exponent, coefficient, n):
    force = np.linspace(0.8, 5.0, n)
    rate = rate_of(lambda f: coefficient * f**exponent, force)
    assert rate.value == pytest.approx(coefficient * (7**exponent - 0.5**exponent) / 6.5, rel=1e-9)
    assert rate.law is not None
    assert (rate.law.coefficient, rate.law.exponent) == pytest.approx((coefficient, exponent), rel=1e-9)
    assert rate.window_n == (0.5, 7.0)


def test_the_window_is_that_asked_for():
    assert rate_of(lambda f: 3 * f, np.linspace(1, 2, 9), window_n=(1.0, 3.0)).value == pytest.approx(3.0)
    assert PowerLaw(2.0, 2.0).mean_rate(1.0, 3.0) == pytest.approx(8.0)


CURVES = {
    "Hertz": lambda f: 60 * f ** (2 / 3),
    "on an offset": lambda f: 40 + 60 * f ** (2 / 3),
    "stiffening": lambda f: 100 * f ** (2 / 3) / (1 + 0.06 * f),
    "saturating": lambda f: 300 * (1 - np.exp(-f / 3)),
}


@pytest.mark.parametrize("name", CURVES)
def test_the_rate_depends_less_on_where_frames_fall_than_a_slope_does(name):
    rng = np.random.default_rng(3)
    forces = [few_frames(rng) for _ in range(100)]
    power, slope = (
        np.array([rate_of(CURVES[name], f, rule=rule).value for f in forces]) for rule in ("power", "slope")
    )
    assert power.std() / power.mean() < 0.7 * slope.std() / slope.mean()
    area = CURVES[name]
    assert power.mean() == pytest.approx((area(7.0) - area(0.5)) / 6.5, rel=0.03)


@pytest.mark.parametrize(("frames", "least"), [(6, 0.88), (8, 0.9), (20, 0.9), (60, 0.9)])
def test_interval_covers_the_rate_for_errors_of_area_and_force(frames, least):
    rng = np.random.default_rng(5)
    true = 60 * (7 ** (2 / 3) - 0.5 ** (2 / 3)) / 6.5
    covered = 0
    for _ in range(400):
        force = few_frames(rng, frames)
        area = 60 * force ** (2 / 3) * np.exp(0.01 * rng.standard_normal(frames))
        rate = spread_rate(area, force + 0.01 * rng.standard_normal(frames))
        covered += rate.scatter_low <= true <= rate.scatter_high
    assert least < covered / 400 < 0.985


def test_four_frames_have_a_rate_and_no_interval():
    rate = rate_of(CURVES["Hertz"], np.array([0.6, 2.0, 4.0, 6.5]))
    assert rate.scatter_low is None
    assert rate.notes == ("No interval: 4 points are too few to judge their error.",)


def test_a_wild_area_does_not_move_the_rate():
    force = np.linspace(0.5, 7, 30)
    area = CURVES["Hertz"](force) * np.exp(0.003 * np.random.default_rng(1).standard_normal(30))
    wild = area.copy()
    wild[[4, 25]] *= (2.0, 0.5)
    assert spread_rate(wild, force).value == pytest.approx(spread_rate(area, force).value, rel=0.01)


def test_frames_far_from_the_window_are_said():
    assert rate_of(CURVES["Hertz"], np.linspace(0.6, 6, 20)).notes == ()
    (said,) = rate_of(CURVES["Hertz"], np.linspace(0.6, 3, 20)).notes
    assert "0.6 to 3 N" in said
    assert "0.5 to 7 N" in said


def test_areas_that_no_power_law_has_are_refused():
    with pytest.raises(FramesError, match="1 of 5"):
        spread_rate([0.0, 1, 2, 3, 4], [1.0, 2, 3, 4, 5])


def test_student_quantile_is_that_of_scipy():
    for freedom in (3, 5, 10, 60):
        assert student_quantile(0.95, freedom) == pytest.approx(stats.t.ppf(0.975, freedom), rel=0.01)
