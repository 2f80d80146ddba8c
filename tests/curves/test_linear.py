"""Linear regression against NIST's certified values, statsmodels, and what must not change the answer."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import statsmodels.api as sm
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.nist import LINEAR_DEGREE, digits, read_regression
from benchmarks.statistics.linear import LinearFit, fit_linear, powers
from emg2vsa.errors import DataError

DOUBLE = {
    "Norris": 14, "Pontius": 13, "NoInt1": 14.5, "NoInt2": 14.5, "Filip": 7.5, "Longley": 12.5,
    "Wampler1": 12, "Wampler2": 12, "Wampler3": 12, "Wampler4": 10.5, "Wampler5": 8.5,
}  # fmt: skip
"""Digits of the worst coefficient when powers come rounded to doubles (exact arithmetic on them: 7.6 for Filip)."""
EXTENDED = DOUBLE | {"Filip": 10.0, "Longley": 14.0}
needs_extended = pytest.mark.skipif(np.finfo(np.longdouble).eps > 1e-18, reason="no extended precision here")


def fitted(path: Path, dtype: type) -> tuple[LinearFit, float, float, float]:
    """The fit, and digits of the worst coefficient, of the worst error, of R2."""
    data = read_regression(path)
    degree = LINEAR_DEGREE[data.name]
    x = data.x.astype(np.longdouble) if degree is None else powers(data.x[:, 0], degree)
    intercept = not data.name.startswith("NoInt")
    fit = fit_linear(x.astype(dtype), data.y.astype(np.longdouble), intercept=intercept)
    of_coefficients = min(digits(*pair) for pair in zip(fit.coefficients[0], data.estimates, strict=True))
    of_errors = min(digits(*pair) for pair in zip(fit.se[0], data.errors, strict=True))
    return fit, of_coefficients, of_errors, digits(fit.r2[0], data.r2 or "1")


@needs_extended
@pytest.mark.parametrize("name", LINEAR_DEGREE)
def test_nist_from_decimal_text(name: str, shared_data: Callable[[str], Path]) -> None:
    _, coefficients, errors, r2 = fitted(shared_data(f"nist/nist_linear/{name}.dat"), np.longdouble)
    assert coefficients >= EXTENDED[name]
    assert errors >= min(EXTENDED[name], 13)
    assert r2 >= 13.5


@needs_extended
@pytest.mark.parametrize("name", LINEAR_DEGREE)
def test_nist_from_doubles(name: str, shared_data: Callable[[str], Path]) -> None:
    assert fitted(shared_data(f"nist/nist_linear/{name}.dat"), np.float64)[1] >= DOUBLE[name]


def design(seed: int, d: int = 3, n: int = 20, p: int = 3) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    x = rng.standard_normal((d, n, p))
    return x, 2 + x @ np.arange(1.0, p + 1) + rng.standard_normal((d, n))


@pytest.mark.parametrize("intercept", [True, False])
def test_batch_is_statsmodels(intercept: bool) -> None:
    x, y = design(1)
    y[1, 4:7], x[2, 3, 1] = np.nan, np.nan
    fit = fit_linear(x, y, intercept=intercept)
    for i in range(3):
        peer = sm.OLS(y[i], sm.add_constant(x[i]) if intercept else x[i], missing="drop").fit()
        np.testing.assert_allclose(fit.coefficients[i], peer.params, rtol=1e-11)
        np.testing.assert_allclose(fit.se[i], peer.bse, rtol=1e-11)
        np.testing.assert_allclose(fit.covariance[i], peer.cov_params(), rtol=1e-10, atol=1e-14)
        np.testing.assert_allclose([fit.r2[i], fit.adj_r2[i]], [peer.rsquared, peer.rsquared_adj], rtol=1e-11)
        assert (fit.n[i], fit.dof[i]) == (peer.nobs, peer.df_resid)


@given(st.integers(0, 2**32 - 1), st.floats(1e-6, 1e6), st.floats(-1e3, 1e3))
@settings(max_examples=40, deadline=None)
def test_units_shift_and_order(seed: int, unit: float, shift: float) -> None:
    x, y = design(seed, d=1)
    fit = fit_linear(x, y)
    order = np.random.default_rng(seed).permutation(20)
    moved = fit_linear(x[:, order] * unit, y[:, order] + shift)
    np.testing.assert_allclose(moved.coefficients[0, 1:] * unit, fit.coefficients[0, 1:], rtol=1e-8, atol=1e-10)
    np.testing.assert_allclose(moved.coefficients[0, 0], fit.coefficients[0, 0] + shift, rtol=1e-8, atol=1e-10)
    np.testing.assert_allclose(moved.se[0, 1:] * unit, fit.se[0, 1:], rtol=1e-8)


@pytest.mark.parametrize("scale", [1e-300, 1e300])
def test_extreme_scales_cost_no_digits(scale: float) -> None:
    x, y = design(2)
    y /= 100
    fit, tall, wide = fit_linear(x, y), fit_linear(x, y * scale), fit_linear(x * scale, y)
    np.testing.assert_allclose(tall.coefficients / scale, fit.coefficients, rtol=1e-12)
    np.testing.assert_allclose(tall.se / scale, fit.se, rtol=1e-12)
    np.testing.assert_allclose(tall.r2, fit.r2, rtol=1e-12)
    np.testing.assert_allclose(wide.coefficients[:, 1:] * scale, fit.coefficients[:, 1:], rtol=1e-12)


@pytest.mark.parametrize("tie", [0.1, 1.0, 0.0])
def test_columns_that_depend_on_each_other_are_refused_not_dropped(tie: float) -> None:
    x, y = design(3, d=1)
    x[:, :, 2] = tie * x[:, :, 1]
    fit = fit_linear(x, y)
    assert np.isnan(fit.coefficients).all()
    assert np.isnan([fit.se[0, 0], fit.s[0], fit.r2[0]]).all()
    assert fit.notes() == ("undefined: one column is a sum of the others",)


def test_few_points() -> None:
    x, y = design(4, d=1, n=4)
    fit = fit_linear(x, y)
    np.testing.assert_allclose(fit.coefficients[0, 0] + x[0] @ fit.coefficients[0, 1:], y[0], rtol=1e-10)
    assert np.isnan(fit.se).all()
    assert fit.notes() == ("as many coefficients as points: no errors",)
    fewer = fit_linear(x[:, :3], y[:, :3])
    assert np.isnan(fewer.coefficients).all()
    assert fewer.notes() == ("undefined: 3 points",)


def test_constant_y_has_no_r2() -> None:
    x, _ = design(5, d=1)
    fit = fit_linear(x, np.full((1, 20), 3.0))
    np.testing.assert_allclose(fit.coefficients[0], [3, 0, 0, 0], atol=1e-15)
    assert np.isnan(fit.r2[0])


def test_wrong_shapes_are_named() -> None:
    with pytest.raises(DataError, match=r"found \(4, 2\) and \(1, 5\)"):
        fit_linear(np.ones((4, 2)), np.ones(5))
    with pytest.raises(DataError, match="as many designs"):
        fit_linear(np.ones((2, 4, 2)), np.ones((3, 4)))
