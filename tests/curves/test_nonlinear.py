"""General least squares: all 27 nonlinear sets of NIST from both starts, and input that has no answer."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy import optimize

from benchmarks.nist import MODELS, digits, nonlinear_data, read_regression
from emg2vsa.curves.exponential import fit_exponential
from emg2vsa.curves.nonlinear import _polished, fit_nonlinear
from emg2vsa.errors import DataError

X = np.linspace(0.1, 2, 15)
Y = 3 * np.exp(-1.2 * X) + 0.02 * np.random.default_rng(0).standard_normal(15)


def exponential(x: np.ndarray, b: np.ndarray) -> np.ndarray:
    return b[0] * np.exp(b[1] * x)


@pytest.mark.parametrize("start", [0, 1])
@pytest.mark.parametrize("name", MODELS)
def test_nist_certified_values_from_both_starts(name: str, start: int, shared_data: Callable[[str], Path]) -> None:
    data = read_regression(shared_data(f"nist/nist_nonlinear/{name}.dat"))
    x, y = nonlinear_data(data)
    fit = fit_nonlinear(MODELS[name], x, y, data.starts[start])
    assert min(digits(*pair, cap=11) for pair in zip(fit.parameters, data.estimates, strict=True)) >= 10
    # the residuals of Lanczos1 are 1e-13: its errors are rounding
    enough = 3 if name == "Lanczos1" else 10
    assert min(digits(*pair, cap=11) for pair in zip(fit.se, data.errors, strict=True)) >= enough
    assert digits(fit.s, data.residual_sd, cap=11) >= enough
    assert fit.notes == ()


def test_there_are_27_sets() -> None:
    assert len(MODELS) == 27


def test_covariance_is_scipys_and_the_exponential_fit_agrees() -> None:
    fit = fit_nonlinear(exponential, X, Y, [1, -1])
    _, covariance = optimize.curve_fit(lambda x, p, q: p * np.exp(q * x), X, Y, fit.parameters)
    np.testing.assert_allclose(fit.covariance, covariance, rtol=1e-4)
    np.testing.assert_allclose(np.sqrt(np.diag(fit.covariance)), fit.se, rtol=1e-14)
    special = fit_exponential(X, Y)
    p = special.y0[0] * np.exp(-special.q[0] * special.x0[0])
    np.testing.assert_allclose(fit.parameters, [p, special.q[0]], rtol=1e-13)
    assert (fit.n, fit.dof) == (15, 13)


@pytest.mark.parametrize("scale", [1e-100, 1e100])
def test_large_and_small_units(scale: float) -> None:
    fit, other = fit_nonlinear(exponential, X, Y, [1, -1]), fit_nonlinear(exponential, X, scale * Y, [scale, -1])
    np.testing.assert_allclose(other.parameters / [scale, 1], fit.parameters, rtol=1e-12)
    np.testing.assert_allclose(other.se / [scale, 1], fit.se, rtol=1e-10)


def test_a_parameter_that_the_data_do_not_determine_has_no_error() -> None:
    fit = fit_nonlinear(lambda x, b: b[0] + b[1] + 0 * x, X, Y, [1, 1])
    np.testing.assert_allclose(np.sum(fit.parameters), np.mean(Y), rtol=1e-12)
    assert np.isnan(fit.se).all()
    assert fit.notes == ("the data do not determine all parameters: no errors",)


def test_as_many_parameters_as_points() -> None:
    fit = fit_nonlinear(exponential, [0.0, 1.0], [1.0, 2.0], [1, 0.5])
    np.testing.assert_allclose(fit.parameters, [1, np.log(2)], rtol=1e-12)
    assert np.isnan(fit.se).all()
    assert fit.notes == ("as many parameters as points: no errors",)


@pytest.mark.parametrize(
    ("y", "start", "said"),
    [
        ([1.0, np.nan, 2.0], [1, 1], "finite y"),
        ([1.0, 2.0], [1, np.inf], "finite y"),
        ([1.0], [1, 1], "1 points, 2 parameters"),
        ([1.0, 2.0, 3.0], [1, 1e4], "finite curve at the start"),
    ],
)
def test_input_without_an_answer_is_refused(y: list[float], start: list[float], said: str) -> None:
    with pytest.raises(DataError, match=said):
        fit_nonlinear(exponential, np.arange(1.0, len(y) + 1), y, start)


def _polished_on(map_of_errors: np.ndarray, root: np.ndarray, start: np.ndarray, rounding: float) -> np.ndarray:
    """Error left by `_polished` where a step turns an error e into map @ e, and the residuals are root @ e."""
    jacobian = root @ np.linalg.inv(np.eye(2) - map_of_errors)
    one = np.ones(2)
    return _polished(one + start, lambda b: root @ (b - one), lambda b: jacobian, rounding) - one


def test_steps_that_turn_about_the_end_are_followed() -> None:
    """One of them is longer than the one before it, measured by the parameter that moves most."""
    turn = 0.3 * np.array([[np.cos(1.3), -np.sin(1.3)], [np.sin(1.3), np.cos(1.3)]])
    stretch = np.diag([1.0, 10.0])
    left = _polished_on(stretch @ turn @ np.linalg.inv(stretch), np.linalg.inv(stretch), np.array([1e-5, 1e-6]), 0.0)
    assert np.abs(left).max() < 1e-14


def test_steps_that_grow_are_not_followed() -> None:
    """Where rounding hides that the sum of squares grows, the first step may be long, and none after it longer."""
    left = _polished_on(np.diag([-1.5, 0.1]), np.eye(2), np.array([1e-5, 1e-5]), 1.0)
    np.testing.assert_allclose(left, [-1.5e-5, 1e-6], rtol=1e-6)
