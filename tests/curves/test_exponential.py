"""y = p exp(q x) against 50-digit arithmetic, NIST, scipy, brute force and its own invariances."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.nist import digits, read_regression
from emg2vsa.curves.exponential import ExponentialFit, fit_exponential, fit_exponential_log
from emg2vsa.errors import DataError

seeds = st.integers(0, 2**32 - 1)


def curve(seed: int, n: int = 12, noise: float = 0.05) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    x = np.sort(rng.uniform(0.1, 1.5, n)) * 10 ** rng.uniform(-3, 1)
    return x, 10 * np.exp(-rng.uniform(0.3, 4) / x.max() * x) * (1 + noise * rng.standard_normal(n))


def exact_fit(x: np.ndarray, y: np.ndarray, near: float) -> dict[str, mpmath.mpf]:
    with mpmath.workdps(50):
        xs, ys = ([mpmath.mpf(float(value)) for value in values] for values in (x, y))

        def at(q: mpmath.mpf) -> tuple[mpmath.mpf, ...]:
            u = [mpmath.exp(q * value) for value in xs]
            uu = sum(ui**2 for ui in u)
            p = sum(ui * yi for ui, yi in zip(u, ys, strict=True)) / uu
            centre = sum(ui**2 * xi for ui, xi in zip(u, xs, strict=True)) / uu
            points = list(zip(u, xs, ys, strict=True))
            gradient = sum((yi - p * ui) * (xi - centre) * ui for ui, xi, yi in points)
            return gradient, p

        start = mpmath.mpf(near)
        q = mpmath.findroot(lambda q: at(q)[0], (start, start * (1 + mpmath.mpf(10) ** -8)), tol=1e-90, verify=False)
        _, p = at(q)
        return {"p": p, "q": q}


def p_of(fit: ExponentialFit) -> np.ndarray:
    return fit.y0 * np.exp(-fit.q * fit.x0)


def at(fit: ExponentialFit, x: np.ndarray) -> np.ndarray:
    return fit.y0[:, None] * np.exp(fit.q[:, None] * (x - fit.x0[:, None]))


def fewest_digits(fit: ExponentialFit, truth: dict[str, mpmath.mpf]) -> float:
    found = {"p": p_of(fit)[0], "q": fit.q[0]}
    return min(digits(found[name], mpmath.nstr(value, 30)) for name, value in truth.items())


@pytest.mark.parametrize("n", [3, 6, 30])
def test_every_number_has_13_digits(n: int) -> None:
    for seed in range(10):
        x, y = curve(seed, n)
        fit = fit_exponential(x, y)
        assert fewest_digits(fit, exact_fit(x, y, fit.q[0])) >= 13


def test_danwood_is_certified(shared_data: Callable[[str], Path]) -> None:
    data = read_regression(shared_data("nist/nist_nonlinear/DanWood.dat"))
    fit = fit_exponential(np.log(data.x[:, 0].astype(float)), data.y.astype(float))
    found = (p_of(fit)[0], fit.q[0])
    assert min(digits(value, truth, cap=11) for value, truth in zip(found, data.estimates, strict=True)) >= 11


def test_mgh10_with_its_third_parameter_given(shared_data: Callable[[str], Path]) -> None:
    data = read_regression(shared_data("nist/nist_nonlinear/MGH10.dat"))
    fit = fit_exponential(1 / (data.x[:, 0].astype(float) + float(data.estimates[2])), data.y.astype(float))
    assert digits(p_of(fit)[0], data.estimates[0]) >= 9.5
    assert digits(fit.q[0], data.estimates[1]) >= 10.5


def test_thousands_of_designs_are_fitted_as_alone() -> None:
    curves = [curve(seed, 8) for seed in range(2000)]
    x, y = np.array([c[0] for c in curves]), np.array([c[1] for c in curves])
    together = fit_exponential(x, y)
    for i in (0, 999, 1999):
        alone = fit_exponential(x[i], y[i])
        np.testing.assert_allclose([p_of(together)[i], together.q[i]], [p_of(alone)[0], alone.q[0]], rtol=1e-13)


def test_many_rows_that_share_x_and_y_are_as_many_fits() -> None:
    x, y = curve(4)
    alone, many = fit_exponential(x, y), fit_exponential(x, np.broadcast_to(y, (200, y.size)))
    for name in ("x0", "y0", "q"):
        np.testing.assert_allclose(getattr(many, name), np.full(200, getattr(alone, name)[0]), rtol=1e-14)


def test_noise_of_any_size_ends_in_the_deepest_minimum() -> None:
    rng = np.random.default_rng(3)
    x, y = np.linspace(0, 1, 9), rng.uniform(0.05, 1, (300, 9))
    q = np.linspace(-60, 60, 6001)
    u = np.exp(q[:, None] * (x - (q > 0)[:, None]))
    explained = (y @ u.T) ** 2 / np.sum(u * u, axis=1)
    fit = fit_exponential(x, y)
    rss = np.sum((y - at(fit, x)) ** 2, axis=1)
    deepest = np.sum(y * y, axis=1) - np.max(explained, axis=1)
    assert np.mean(rss <= deepest * (1 + 1e-9)) > 0.98


def test_log_linear_variant_is_a_line_through_ln_y() -> None:
    x, y = curve(4)
    fit = fit_exponential_log(x, y)
    slope, level = np.polyfit(x, np.log(y), 1)
    np.testing.assert_allclose([p_of(fit)[0], fit.q[0]], [np.exp(level), slope], rtol=1e-12)


@given(seeds, st.floats(-3, 3), st.floats(1e-3, 1e3))
@settings(max_examples=40, deadline=None)
def test_origin_and_units(seed: int, shift: float, unit: float) -> None:
    x, y = curve(seed)
    x = x / x.max()
    fit, moved = fit_exponential(x, y), fit_exponential(unit * (x + shift), 7 * y)
    np.testing.assert_allclose(moved.q * unit, fit.q, rtol=1e-9)
    np.testing.assert_allclose(p_of(moved), 7 * p_of(fit) * np.exp(-fit.q * shift), rtol=1e-9)


@given(seeds)
@settings(max_examples=30, deadline=None)
def test_order_mirror_and_padding(seed: int) -> None:
    x, y = curve(seed)
    order = np.random.default_rng(seed).permutation(x.size)
    fit = fit_exponential(x, y)
    np.testing.assert_allclose(fit_exponential(x[order], y[order]).q, fit.q, rtol=1e-10)
    np.testing.assert_allclose(fit_exponential(-x, y).q, -fit.q, rtol=1e-10)
    np.testing.assert_allclose(p_of(fit_exponential(x, -y)), -p_of(fit), rtol=1e-10)
    padded = fit_exponential(np.append(x, [np.nan, 1.0]), np.append(y, [1.0, np.inf]))
    np.testing.assert_allclose([p_of(padded), padded.q], [p_of(fit), fit.q], rtol=1e-10)


@pytest.mark.parametrize("scale", [1e-300, 1e-150, 1e150, 1e300])
def test_extreme_scales_cost_no_digits(scale: float) -> None:
    x, y = curve(5)
    y = y / y.max()
    fit, tall, wide = fit_exponential(x, y), fit_exponential(x, y * scale), fit_exponential(x * scale, y)
    np.testing.assert_allclose(p_of(tall) / scale, p_of(fit), rtol=1e-12)
    np.testing.assert_allclose(wide.q * scale, fit.q, rtol=1e-12)
    np.testing.assert_allclose(p_of(wide), p_of(fit), rtol=1e-12)


@pytest.mark.parametrize("scale", [2.0**-266, 2.0**-259, 2.0**259, 2.0**266])
def test_extreme_scales_of_many_rows_cost_no_digits(scale: float) -> None:
    x, y = np.array([curve(seed) for seed in range(150)]).swapaxes(0, 1)
    np.testing.assert_allclose(fit_exponential(x * scale, y).q * scale, fit_exponential(x, y).q, rtol=1e-12)


def test_two_points_determine_it() -> None:
    fit = fit_exponential([1.0, 3.0], [8.0, 2.0])
    np.testing.assert_allclose([p_of(fit)[0], fit.q[0]], [16.0, -np.log(2)], rtol=1e-14)


def test_a_constant_has_rate_zero() -> None:
    fit = fit_exponential([1.0, 2.0, 3.0], [5.0, 5.0, 5.0])
    np.testing.assert_allclose([p_of(fit)[0], fit.q[0]], [5.0, 0.0], atol=1e-14)


@pytest.mark.parametrize(
    ("x", "y"),
    [
        ([2.0, 2.0, 2.0], [1.0, 2.0, 3.0]),
        ([1.0], [1.0]),
        ([], []),
        ([1.0, 2.0, 3.0], [0.0, 0.0, 0.0]),
        ([1.0, 2.0, np.nan], [np.inf, np.nan, 3.0]),
        ([0.0, 1.0, 2.0], [1.0, -1.0, 0.0]),
        ([0.0, 1.0, 2.0, 3.0], [1.0, 1e-8, -0.5, -0.5]),
    ],
)
def test_undefined_is_nan(x: list[float], y: list[float]) -> None:
    fit = fit_exponential(x, y)
    assert np.isnan([fit.y0[0], fit.q[0]]).all()


def test_a_steep_exact_curve_is_not_taken_for_a_spike() -> None:
    fit = fit_exponential([0.0, 0.5, 1.0], np.exp([0.0, 20.0, 40.0]))
    np.testing.assert_allclose(fit.q[0], 40, rtol=1e-13)


def test_least_squares_takes_negative_values_and_the_logarithm_does_not() -> None:
    x, y = np.arange(6.0), np.array([9.0, 3.1, 1.2, 0.3, -0.05, 0.1])
    fit, log = fit_exponential(x, y), fit_exponential_log(x, y)
    gradient = np.exp(fit.q * x) @ (y - at(fit, x)[0])
    assert abs(gradient) < 1e-13
    assert np.isnan([log.y0[0], log.q[0]]).all()


def test_no_designs_and_wrong_shapes() -> None:
    assert fit_exponential(np.empty((0, 3)), np.empty((0, 3))).q.shape == (0,)
    with pytest.raises(DataError, match=r"x of shape \(2, 3\)"):
        fit_exponential(np.ones(2), np.ones((2, 3)))
    with pytest.raises(DataError, match="y of shape"):
        fit_exponential(np.ones(3), np.ones((1, 2, 3)))
