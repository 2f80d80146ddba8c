"""Areas from growth; the spread rate from areas and forces, as a slope and on a power law; its total interval."""

from __future__ import annotations

import warnings
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from casr.spread import RATE_RULES, PowerLaw, contact_areas, fit_power_laws, spread_rate
from casr.spread.curves import CURVATURE
from casr.spread.intervals import student_quantile, total_interval
from casr.spread.rate import pooled

slope = partial(spread_rate, rule="slope")


def press(frames=61, shape=1.0):
    """Force from 0.5 to 7 N and area ~ F^(1/2), as the simulated world has it."""
    force = 0.5 + 6.5 * np.linspace(0, 1, frames) ** shape
    return 80 * np.sqrt(force / 0.5), force


def exact_slope(low=0.5, high=7.0):
    """Least-squares slope of 80 sqrt(F / 0.5) over [low, high], by fine quadrature."""
    force = np.linspace(low, high, 200_001)
    return np.polyfit(force, 80 * np.sqrt(force / 0.5), 1)[0]


def autoregressive(rng, n, correlation):
    errors = rng.normal(size=n)
    for i in range(1, n):
        errors[i] = correlation * errors[i - 1] + np.sqrt(1 - correlation**2) * errors[i]
    return errors


def test_ode_areas_undo_the_logarithm_of_growth():
    area, force = press()
    assert contact_areas(80.0, np.diff(np.log(area)), force) == pytest.approx(area, rel=1e-13)
    assert contact_areas(80.0, np.diff(np.log(area))) == pytest.approx(area, rel=1e-13)


def test_paper_areas_are_equation_1_as_printed():
    areas = contact_areas(10.0, [0.01, 0.02, 0.03], [0.5, 1.0, 2.0, 3.0], law="paper")
    assert areas == pytest.approx(10 * np.exp(0.06 * np.array([0.0, 1.0, 2.0, 3.0])))


@given(st.lists(st.floats(-0.5, 0.5), min_size=1, max_size=30), st.integers(0, 30))
def test_ode_areas_can_be_continued_from_any_frame(growth, cut):
    cut = min(cut, len(growth))
    first = contact_areas(5.0, growth[:cut])
    assert np.append(first, contact_areas(first[-1], growth[cut:])[1:]) == pytest.approx(contact_areas(5.0, growth))


@pytest.mark.parametrize("law", ["ode", "paper"])
@pytest.mark.parametrize("rule", RATE_RULES)
def test_no_initial_area_gives_no_area_and_no_rate(law, rule):
    area = contact_areas(0.0, np.full(9, 0.1), np.arange(1.0, 11.0), law=law)
    assert not area.any()
    assert spread_rate(area, np.arange(1.0, 11.0), rule=rule).value == 0.0


def test_slope_of_a_line_is_exact_with_an_interval_of_nothing():
    force = np.linspace(0.5, 7, 40)
    rate = slope(3 + 2 * force, force, area_unit="px2")
    assert (rate.value, rate.scatter_low, rate.scatter_high) == pytest.approx((2, 2, 2), rel=1e-9)
    assert rate.unit == "px2/N"


@pytest.mark.parametrize("shape", [0.7, 1.0, 1.5, 2.0])
@pytest.mark.parametrize("frames", [31, 61, 121])
def test_slope_is_that_of_the_curve_whatever_frame_rate_and_loading(frames, shape):
    area, force = press(frames, shape)
    assert slope(area, force).value == pytest.approx(exact_slope(), rel=0.004)


def test_paper_rate_is_equation_2_and_doubles_with_the_frame_rate():
    area, force = press()
    expected = (np.diff(area) / np.diff(np.append(0.0, force[1:]))).sum()
    rate = spread_rate(area, force, rule="paper")
    assert rate.value == pytest.approx(expected)
    assert rate.unit == "mm2/N summed over frames"
    assert rate.scatter_low is None
    assert spread_rate(area[::2], force[::2], rule="paper").value == pytest.approx(expected / 2, rel=0.05)


def test_paper_merges_small_steps_and_loses_no_area():
    area, force = [10.0, 11.0, 11.5, 12.0, 13.0, 13.5], [0.5, 1.0, 1.001, 1.002, 1.5, 1.501]
    rate = spread_rate(area, force, rule="paper")
    assert rate.value == pytest.approx(1.0 / 1.0 + (13.5 - 11.0) / (1.501 - 1.0))
    assert "3 of 5 steps" in rate.notes[0]


@pytest.mark.parametrize("dip_n", [0.3, 1.0, 3.0])
@pytest.mark.parametrize("kept", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("rule", ["power", "slope"])
def test_dips_of_force_hardly_change_the_rate(dip_n, kept, rule):
    """kept: share of the area that stays when the force goes back; 0 is elastic, 1 sticks."""
    time = np.linspace(0, 1, 130)
    dips = sum(np.exp(-(((time - middle) / 0.03) ** 2)) for middle in (0.25, 0.5, 0.75))
    force = np.maximum(0.5 + 6.5 * time - dip_n * dips, 0.5)
    area = 80 * ((1 - kept) * np.sqrt(force) + kept * np.sqrt(np.maximum.accumulate(force)))
    truth = spread_rate(80 * np.sqrt(0.5 + 6.5 * time), 0.5 + 6.5 * time, rule=rule).value
    rate = spread_rate(area, force, rule=rule)
    assert rate.value == pytest.approx(truth, rel=0.001)
    assert dip_n < 1 or "in dips of the force" in rate.notes[0]


def test_noise_of_force_is_pooled_and_not_taken_for_dips():
    noise_n = 0.03 * np.random.default_rng(3).standard_normal((100, 130))
    force = np.linspace(0.5, 7, 130)
    area = 80 * np.sqrt(force)
    rates = [slope(area, force + noise) for noise in noise_n]
    assert np.mean([rate.value for rate in rates]) == pytest.approx(slope(area, force).value, rel=0.002)
    assert all("pooled" in rate.notes[0] for rate in rates)


@given(st.lists(st.floats(0, 10), min_size=1, max_size=40))
def test_pooled_force_rises_and_keeps_all_force_and_area(force):
    force = np.array(force)
    area, rising, _ = pooled(np.arange(force.size, dtype=float), force)
    assert (np.diff(rising) > 0).all()
    assert rising.min() >= force.min() - 1e-9
    assert rising.max() <= force.max() + 1e-9
    assert (np.diff(area) > 0).all()


def test_pooled_agrees_with_scipy():
    optimize = pytest.importorskip("scipy.optimize")
    force = np.random.default_rng(0).normal(size=50).cumsum() + np.arange(50) * 0.3
    expected = np.unique(optimize.isotonic_regression(force).x)
    assert pooled(force, force)[1] == pytest.approx(expected)


def test_a_few_wild_areas_do_not_move_the_slope():
    rng = np.random.default_rng(1)
    area, force = press()
    area = area + rng.normal(size=61)
    wild = area.copy()
    wild[[3, 57]] += (200.0, -200.0)
    clean = slope(area, force).value
    assert slope(wild, force).value == pytest.approx(clean, rel=0.05)
    assert abs(np.polyfit(force, wild, 1)[0] / clean - 1) > 0.15


@pytest.mark.parametrize(("frames", "correlation", "least"), [(30, 0.0, 0.91), (60, 0.3, 0.89), (60, 0.6, 0.86)])
def test_interval_covers_the_noise_free_slope(frames, correlation, least):
    rng = np.random.default_rng(2)
    area, force = press(frames, 1.3)
    truth = slope(area, force).value
    rates = [slope(area + 3 * autoregressive(rng, frames, correlation), force) for _ in range(300)]
    covered = np.mean([rate.scatter_low <= truth <= rate.scatter_high for rate in rates])
    assert least < covered < 0.99
    assert np.mean([rate.value for rate in rates]) == pytest.approx(truth, rel=0.01)


def test_noise_free_bend_is_not_taken_for_noise():
    rate = slope(*press())
    assert rate.scatter_high - rate.scatter_low < 0.005 * rate.value


def test_frames_without_force_are_left_out_and_counted():
    area, force = press()
    force[[0, 10, 60]] = np.nan
    rate = slope(area, force)
    assert rate.n_frames == 58
    assert "3 of 61 frames carry no force" in rate.notes[0]
    assert rate.value == pytest.approx(slope(area[~np.isnan(force)], force[~np.isnan(force)]).value, rel=1e-12)


@given(st.floats(0.1, 100), st.floats(-50, 50))
def test_slope_scales_with_area_and_ignores_an_offset(scale, offset):
    area, force = press(20)
    assert slope(scale * area + offset, force).value == pytest.approx(scale * slope(area, force).value)


def test_few_points_give_a_slope_without_interval():
    rate = slope([10.0, 14.0], [1.0, 3.0])
    assert rate.value == pytest.approx(2.0)
    assert rate.scatter_low is None
    assert "too few" in rate.notes[0]


def rate_of(area_of, force, **options):
    return spread_rate(area_of(force), force, **options)


def few_frames(rng, n=8):
    """Frames of a fast press: the first lies from 0.5 to 0.8 N, the last from 6.2 to 7.2 N."""
    first, last = rng.uniform(0.5, 0.8), rng.uniform(6.2, 7.2)
    return first + (last - first) * np.linspace(0, 1, n) ** rng.uniform(1, 1.6)


@given(st.floats(0.2, 1.0), st.floats(1, 100), st.integers(5, 40))
def test_a_power_of_force_has_its_exact_mean_rate_wherever_its_frames_lie(exponent, coefficient, n):
    force = np.linspace(0.8, 5.0, n)
    rate = rate_of(lambda f: coefficient * f**exponent, force)
    assert rate.value == pytest.approx(coefficient * (7**exponent - 0.5**exponent) / 6.5, rel=1e-9)
    assert (rate.law.coefficient, rate.law.exponent) == pytest.approx((coefficient, exponent), rel=1e-9)
    assert rate.law.curvature == pytest.approx(0, abs=1e-9)
    assert rate.window_n == (0.5, 7.0)


@given(st.floats(0.4, 0.9), st.floats(-0.06, 0.02), st.integers(5, 40))
def test_an_exponent_that_changes_with_force_is_followed(exponent, curvature, n):
    law = PowerLaw(30.0, exponent, curvature)
    rate = rate_of(law.area, np.linspace(0.8, 5.0, n))
    assert rate.value == pytest.approx((law.area(7.0) - law.area(0.5)) / 6.5, rel=1e-6)
    at = np.array([1.0, 3.0])
    assert law.rate(at) == pytest.approx((law.area(at + 1e-6) - law.area(at - 1e-6)) / 2e-6, rel=1e-6)


@pytest.mark.parametrize("n", [2, 3, 5])
def test_few_frames_bend_as_domes_do(n):
    law = PowerLaw(30.0, 0.7, CURVATURE)
    rate = rate_of(law.area, np.linspace(0.8, 5.0, n))
    assert rate.value == pytest.approx(law.mean_rate(0.5, 7.0), rel=1e-6)


def test_presses_are_fitted_at_once_as_one_by_one():
    rng = np.random.default_rng(4)
    force = np.where(rng.random((40, 12)) < 0.3, np.nan, np.sort(rng.uniform(0.5, 7, (40, 12))))
    force[:3] = np.nan
    force[1:3, 0], force[2, 4] = 1.0, 2.0
    area = 30 * force**0.6 * np.exp(0.02 * rng.standard_t(2, force.shape))
    rates = fit_power_laws(area, force).mean_rates(0.5, 7.0)
    assert np.isnan(rates[:2]).all()
    for rate, a, f in zip(rates[2:], area[2:], force[2:], strict=True):
        assert rate == pytest.approx(spread_rate(a[np.isfinite(a)], f[np.isfinite(f)]).value, rel=1e-7)


def test_scatter_leaves_the_curvature_where_domes_have_it():
    rng = np.random.default_rng(8)
    force, straight = np.linspace(0.6, 2.5, 20), PowerLaw(30.0, 0.7)
    found = {
        sd: np.mean([rate_of(straight.area, force).law.curvature if sd == 0 else
                     spread_rate(straight.area(force) * np.exp(sd * rng.standard_normal(20)), force).law.curvature
                     for _ in range(50)])
        for sd in (0.0, 0.002, 0.1)
    }  # fmt: skip
    assert found[0.0] == pytest.approx(0, abs=1e-9)
    assert abs(found[0.002]) < 0.01
    assert found[0.1] == pytest.approx(CURVATURE, abs=0.005)


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


@pytest.mark.parametrize(("frames", "least"), [(5, 0.88), (6, 0.88), (8, 0.9), (20, 0.9), (60, 0.9)])
@pytest.mark.parametrize("scatter", [0.005, 0.01, 0.04])
def test_interval_covers_the_rate_for_errors_of_area_and_force(frames, scatter, least):
    assert least < coverage(frames, scatter) < 0.985


def test_four_frames_are_taken_to_scatter_by_two_percent_or_more():
    assert coverage(4, 0.01) > 0.985
    assert 0.9 < coverage(4, 0.04) < 0.985


def coverage(frames, scatter):
    rng = np.random.default_rng(5)
    true = 60 * (7 ** (2 / 3) - 0.5 ** (2 / 3)) / 6.5
    covered = 0
    for _ in range(400):
        force = few_frames(rng, frames)
        area = 60 * force ** (2 / 3) * np.exp(scatter * rng.standard_normal(frames))
        rate = spread_rate(area, force + 0.01 * rng.standard_normal(frames))
        covered += rate.scatter_low <= true <= rate.scatter_high
    return covered / 400


def test_three_frames_have_a_rate_and_no_interval():
    rate = rate_of(CURVES["Hertz"], np.array([0.6, 2.0, 4.0]))
    assert rate.scatter_low is None
    assert rate.notes == ("No interval: 3 points are too few to judge their error.",)


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


def test_student_quantile_is_that_of_scipy():
    for freedom in (3, 5, 10, 60):
        assert student_quantile(0.95, freedom) == pytest.approx(stats.t.ppf(0.975, freedom), rel=0.01)


def test_it_reaches_as_far_as_its_parts_together() -> None:
    found = total_interval(10.0, {"scatter": 0.03, "dome": 0.04})
    assert (found.low, found.high) == pytest.approx((10 / np.exp(1.959964 * 0.05), 10 * np.exp(1.959964 * 0.05)))


@pytest.mark.parametrize(("value", "part"), [(0.0, 0.1), (-1.0, 0.1), (np.nan, 0.1), (1.0, np.nan), (1.0, np.inf)])
def test_there_is_none_of_what_is_not_known(value: float, part: float) -> None:
    assert total_interval(value, {"scatter": 0.1, "dome": part}) is None


def test_a_part_that_says_nothing_leaves_everything_possible_without_a_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = total_interval(1.0, {"scatter": 1000.0})
    assert (found.low, found.high) == (0.0, np.inf)
