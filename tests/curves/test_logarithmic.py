"""v = a + b ln F against 50-digit arithmetic, scipy, statsmodels and its own invariances."""

from __future__ import annotations

from decimal import Decimal, localcontext

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from emg2vsa.curves.logarithmic import LEVEL_FLOOR, LogFit, _fit_points, _log_fit, fit_log, level_weights
from emg2vsa.errors import DataError

A_V, B_V = 30e-6, 15e-6
seeds = st.integers(0, 2**32 - 1)


def curve(seed: int, k: int = 1, p: int = 131, noise: float = 5e-6) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    force = np.sort(rng.uniform(0.5, 7.0, (k, p)), axis=1)
    return force, A_V + B_V * np.log(force) + noise * rng.standard_normal((k, p))


def weighted(force: np.ndarray, v: np.ndarray, weights: np.ndarray, robust: bool = False) -> LogFit:
    return _log_fit(_fit_points(np.log(force), v, weights, robust), 0.95)


def exact_fit(force: np.ndarray, v: np.ndarray, weights: np.ndarray) -> dict[str, Decimal]:
    with localcontext() as context:
        context.prec = 50
        w = [Decimal(float(value)) for value in weights]
        x = [Decimal(float(value)).ln() for value in force]
        y = [Decimal(float(value)) for value in v]
        n, total = len(y), sum(w)
        x_mean = sum(wi * xi for wi, xi in zip(w, x, strict=True)) / total
        y_mean = sum(wi * yi for wi, yi in zip(w, y, strict=True)) / total
        sxx = sum(wi * (xi - x_mean) ** 2 for wi, xi in zip(w, x, strict=True))
        b = sum(wi * (xi - x_mean) * (yi - y_mean) for wi, xi, yi in zip(w, x, y, strict=True)) / sxx
        a = y_mean - b * x_mean
        sse = sum(wi * (yi - a - b * xi) ** 2 for wi, xi, yi in zip(w, x, y, strict=True))
        syy = sum(wi * (yi - y_mean) ** 2 for wi, yi in zip(w, y, strict=True))
        s2 = sse / (n - 2)
        return {
            "a": a,
            "b": b,
            "a_se": (s2 * (1 / total + x_mean**2 / sxx)).sqrt(),
            "b_se": (s2 / sxx).sqrt(),
            "r2": 1 - sse / syy,
            "adj_r2": 1 - sse / syy * (n - 1) / (n - 2),
        }


def fewest_digits(fit: LogFit, i: int, truth: dict[str, Decimal]) -> float:
    errors = [abs(Decimal(float(getattr(fit, name)[i])) - value) / abs(value) for name, value in truth.items()]
    return min(16.0, -float(max(*errors, Decimal("1e-17")).log10()))


def test_every_number_has_14_and_a_half_digits() -> None:
    force, v = curve(1, k=21)
    fit = fit_log(force, v)
    assert min(fewest_digits(fit, i, exact_fit(force[i], v[i], np.ones(131))) for i in range(21)) >= 14.5


def test_weighted_fit_has_14_and_a_half_digits() -> None:
    force, v = curve(2, k=11)
    weights = (20e-6 / (A_V + B_V * np.log(force))) ** 2
    fit = weighted(force, v, weights)
    assert min(fewest_digits(fit, i, exact_fit(force[i], v[i], weights[i])) for i in range(11)) >= 14.5


def test_interval_is_scipys() -> None:
    force, v = curve(3)
    fit, peer = fit_log(force, v, confidence=0.9), stats.linregress(np.log(force[0]), v[0])
    reach = stats.t.ppf(0.95, 129) * peer.stderr
    np.testing.assert_allclose([fit.b_lo[0], fit.b_hi[0]], [peer.slope - reach, peer.slope + reach], rtol=1e-12)
    assert fit.n[0] == 131


def test_b_against_log10_is_ln10_times_b() -> None:
    force, v = curve(4)
    b10 = np.polyfit(np.log10(force[0]), v[0], 1)[0]
    np.testing.assert_allclose(b10, fit_log(force, v).b[0] * np.log(10), rtol=1e-12)


def test_padded_rows_are_fitted_like_rows_of_their_own() -> None:
    force, v = curve(5, k=400)
    lengths = np.random.default_rng(5).integers(3, 132, 400)
    keep = np.arange(131) < lengths[:, None]
    padded = fit_log(np.where(keep, force, np.nan), np.where(keep, v, np.nan))
    for i in (0, 57, 200, 399):
        alone = fit_log(force[i, : lengths[i]], v[i, : lengths[i]])
        np.testing.assert_allclose(padded.b[i], alone.b[0], rtol=1e-13)
        np.testing.assert_allclose(padded.b_se[i], alone.b_se[0], rtol=1e-12)
    np.testing.assert_array_equal(padded.n, lengths)


def test_a_masked_point_does_not_count() -> None:
    force_n, v = np.linspace(0.5, 4.0, 60), np.random.default_rng(1).normal(1.0, 0.1, (2, 60))
    hidden = np.zeros((2, 60), np.bool_)
    hidden[0, 5:9] = hidden[1, ::7] = True
    found = fit_log(force_n, np.ma.array(np.where(hidden, 1e3, v), mask=hidden))
    wanted = fit_log(force_n, np.where(hidden, np.nan, v))
    assert found.n.tolist() == [56, 51]
    np.testing.assert_array_equal(found.b, wanted.b)
    np.testing.assert_array_equal(fit_log(np.ma.array(force_n, mask=hidden[0]), v).n, [56, 56])


def test_common_grid_is_the_same_as_repeating_it() -> None:
    grid = np.linspace(0.5, 7, 40)
    v = A_V + B_V * np.log(grid) + 1e-6 * np.random.default_rng(6).standard_normal((5, 40))
    np.testing.assert_array_equal(fit_log(grid, v).b, fit_log(np.tile(grid, (5, 1)), v).b)


@given(seeds, st.floats(-1e-3, 1e-3), st.floats(1e-3, 1e3))
@settings(max_examples=40, deadline=None)
def test_shift_and_scale_of_v(seed: int, shift: float, scale: float) -> None:
    force, v = curve(seed, p=25)
    fit, moved = fit_log(force, v), fit_log(force, shift + scale * v)
    slack = 1e-12 * (abs(shift) + scale * 1e-4)
    np.testing.assert_allclose(moved.b, scale * fit.b, rtol=0, atol=slack)
    np.testing.assert_allclose(moved.a, shift + scale * fit.a, rtol=0, atol=slack)
    np.testing.assert_allclose(moved.r2, fit.r2, rtol=1e-7)


@given(seeds, st.floats(1e-3, 1e3))
@settings(max_examples=40, deadline=None)
def test_unit_of_force_moves_a_but_not_b(seed: int, unit: float) -> None:
    force, v = curve(seed, p=25)
    fit, other = fit_log(force, v), fit_log(force * unit, v)
    np.testing.assert_allclose(other.b, fit.b, rtol=1e-10)
    np.testing.assert_allclose(other.a, fit.a - fit.b * np.log(unit), rtol=0, atol=1e-14)


@given(seeds, st.booleans(), st.floats(1e-6, 1e6))
@settings(max_examples=40, deadline=None)
def test_order_of_points_and_unit_of_weights_do_not_matter(seed: int, robust: bool, unit: float) -> None:
    force, v = curve(seed, p=25)
    rng = np.random.default_rng(seed)
    weights, order = rng.uniform(0.1, 1, v.shape), rng.permutation(25)
    fit = weighted(force, v, weights, robust)
    other = weighted(force[:, order], v[:, order], unit * weights[:, order], robust)
    for name in ("a", "b", "a_se", "b_se"):
        np.testing.assert_allclose(getattr(other, name), getattr(fit, name), rtol=1e-8)


def test_weight_zero_leaves_a_point_out() -> None:
    force, v = curve(7, p=30)
    weights = np.ones((1, 30))
    weights[0, [0, 13]] = 0, -1
    v[0, 0] = 1e3
    fit, without = weighted(force, v, weights), fit_log(np.delete(force, [0, 13], 1), np.delete(v, [0, 13], 1))
    np.testing.assert_allclose(fit.b, without.b, rtol=1e-13)
    assert fit.n[0] == 28


@pytest.mark.parametrize("scale", [1e-300, 1e-160, 1e160, 1e300])
@pytest.mark.parametrize("robust", [False, True])
def test_extreme_scales_cost_no_digits(scale: float, robust: bool) -> None:
    force, v = curve(8, k=3)
    v /= A_V
    fit, extreme = fit_log(force, v, robust=robust), fit_log(force, v * scale, robust=robust)
    np.testing.assert_allclose(extreme.b / scale, fit.b, rtol=1e-10)
    np.testing.assert_allclose(extreme.b_se / scale, fit.b_se, rtol=1e-9)
    np.testing.assert_allclose(extreme.adj_r2, fit.adj_r2, rtol=1e-9)


def test_large_offset_costs_no_more_digits_than_the_input_lost() -> None:
    force, v = np.linspace(0.5, 7, 50), np.round(1e6 * np.log(np.linspace(0.5, 7, 50))) / 2**10
    np.testing.assert_allclose(fit_log(force, v + 2**30).b_se, fit_log(force, v).b_se, rtol=1e-13)


def test_two_points_give_a_line_without_errors() -> None:
    fit = fit_log([1.0, np.e], [2.0, 5.0])
    np.testing.assert_allclose([fit.a[0], fit.b[0]], [2.0, 3.0], rtol=1e-15)
    assert np.isnan([fit.a_se[0], fit.b_se[0], fit.b_lo[0], fit.adj_r2[0]]).all()


@pytest.mark.parametrize("robust", [False, True])
@pytest.mark.parametrize(
    ("force", "v"),
    [([2.0], [1.0]), ([2.0, 2.0, 2.0], [1.0, 2.0, 3.0]), ([0.0, -1.0, np.nan], [1.0, 2.0, 3.0]), ([], [])],
)
def test_undefined_is_nan_not_an_error(force: list[float], v: list[float], robust: bool) -> None:
    fit = fit_log(force, v, robust=robust)
    assert np.isnan([fit.b[0], fit.b_se[0], fit.r2[0]]).all()


def test_constant_activity_has_slope_zero_and_no_r2() -> None:
    fit = fit_log(np.linspace(0.5, 7, 9), np.full(9, 0.1))
    assert fit.b[0] == 0
    assert fit.a[0] == 0.1
    assert fit.b_se[0] == 0
    assert np.isnan(fit.r2[0])


def test_no_trials() -> None:
    assert fit_log(np.empty((0, 5)), np.empty((0, 5))).b.shape == (0,)


def test_robust_is_statsmodels_rlm() -> None:
    rlm = pytest.importorskip("statsmodels.api")
    force, v = curve(9, k=4, p=60)
    v[:, 5:9] += 60e-6
    fit = fit_log(force, v, robust=True)
    for i in range(4):
        design = rlm.add_constant(np.log(force[i]))
        peer = rlm.RLM(v[i] * 1e6, design, M=rlm.robust.norms.HuberT()).fit(tol=1e-12, maxiter=500)
        np.testing.assert_allclose([fit.a[i], fit.b[i]], peer.params * 1e-6, rtol=1e-6)
        np.testing.assert_allclose([fit.a_se[i], fit.b_se[i]], peer.bse * 1e-6, rtol=1e-5)


def test_robust_shrugs_off_a_burst() -> None:
    force, v = curve(10, k=200)
    v[:, 100:104] += 200e-6
    plain, robust = fit_log(force, v), fit_log(force, v, robust=True)
    assert np.std(robust.b) < 0.15 * B_V
    assert np.abs(np.mean(robust.b) - B_V) < 0.25 * np.abs(np.mean(plain.b) - B_V)


def test_robust_finds_the_line_that_most_points_share() -> None:
    force = np.linspace(0.5, 7, 20)
    v = A_V + B_V * np.log(force)
    v[3] += 1.0
    np.testing.assert_allclose(fit_log(force, v, robust=True).b, B_V, rtol=1e-6)


def test_level_weights_are_inverse_squares_with_a_floor() -> None:
    force = np.array([0.01, 1.0, np.e])
    fit = fit_log([1.0, np.e, np.e**2], [1.0, 2.0, 3.0])
    np.testing.assert_allclose(level_weights(fit.at(force))[0], [LEVEL_FLOOR**-2, 4.0, 1.0], rtol=1e-14)


def test_level_weights_are_equal_where_there_is_no_level() -> None:
    nowhere_positive, undefined = fit_log([1.0, 2.0, 3.0], [-1.0, -2.0, -3.5]), fit_log([1.0], [1.0])
    assert (level_weights(nowhere_positive.at([1.0, 2.0])) == 1).all()
    assert (level_weights(undefined.at([1.0, 2.0])) == 1).all()


@pytest.mark.parametrize("robust", [False, True])
def test_shapes_that_do_not_fit_are_told(robust: bool) -> None:
    with pytest.raises(DataError, match=r"logarithmic fit, force_n and v: expected x of shape \(2, 5\) or \(5,\), but"):
        fit_log(np.ones(4), np.ones((2, 5)), robust)
    with pytest.raises(DataError, match=r"expected y of shape \(designs, points\), but found \(1, 2, 5\)"):
        fit_log(np.ones(5), np.ones((1, 2, 5)), robust)
