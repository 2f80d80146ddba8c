"""The monotone spline: exact where it holds the curve, monotone whatever the points, its means those of quadrature."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy import integrate

from emg2vsa import artifacts
from emg2vsa.curves.monotone_spline import fit_monotone, mean_spline
from emg2vsa.errors import DataError

RANGE_N = (0.5, 7.0)
FORCE_N = np.linspace(*RANGE_N, 40)
EVERY = np.linspace(*RANGE_N, 1000)


@pytest.mark.parametrize("b", [15.0, -4.0, 0.0])
def test_the_logarithm_is_found_exactly(b: float) -> None:
    spline = fit_monotone(FORCE_N, 30 + b * np.log(FORCE_N), np.ones(40), RANGE_N)
    np.testing.assert_allclose(spline.at(EVERY), 30 + b * np.log(EVERY), rtol=1e-9)


@pytest.mark.parametrize(
    ("law", "within"),
    [
        (lambda f: 5 + 8 * f, 0.005), (lambda f: 8 + 50 / (1 + np.exp(-1.6 * (f - 3.5))), 0.02),
        (lambda f: 60 * (1 - np.exp(-f / 1.2)), 0.005),
    ],
)  # fmt: skip
def test_other_laws_are_followed(law, within: float) -> None:  # type: ignore[no-untyped-def]
    spline = fit_monotone(FORCE_N, law(FORCE_N), np.ones(40), RANGE_N)
    assert np.max(np.abs(spline.at(EVERY) - law(EVERY))) < within * law(EVERY).max()


@pytest.mark.parametrize("seed", range(5))
def test_any_points_give_a_monotone_curve(seed: int) -> None:
    rng = np.random.default_rng(seed)
    v, weights = rng.standard_normal(40) * 10 ** rng.uniform(-6, 6), rng.uniform(0.1, 2, 40)
    step = np.diff(fit_monotone(FORCE_N, v, weights, RANGE_N).at(EVERY))
    rounding = 1e-12 * np.abs(v).max()
    assert np.all(step >= -rounding) or np.all(step <= rounding)


def test_points_without_weight_or_value_do_not_count() -> None:
    v, weights = 30 + 15 * np.log(FORCE_N), np.ones(40)
    v[3], v[10], weights[10] = np.nan, 1e6, 0.0
    force_n = np.append(FORCE_N, 9.0)
    spline = fit_monotone(force_n, np.append(v, 500.0), np.append(weights, 1.0), RANGE_N)
    np.testing.assert_allclose(spline.at(EVERY), 30 + 15 * np.log(EVERY), rtol=1e-9)


def test_weights_are_inverse_variances() -> None:
    f, v = np.repeat(3.0, 2), np.array([1.0, 5.0])
    spline = fit_monotone(f, v, np.array([3.0, 1.0]), RANGE_N)
    assert spline.at(np.array(3.0)) == pytest.approx(2.0)


def test_means_over_steps_are_those_of_quadrature() -> None:
    spline = fit_monotone(FORCE_N, 60 * (1 - np.exp(-FORCE_N / 1.2)), np.ones(40), RANGE_N)
    edges = np.array([0.5, 0.8, 3.0, 6.8, 7.0])
    for mean, low, high in zip(spline.mean_over_steps(edges), edges[:-1], edges[1:], strict=True):
        whole = integrate.quad(lambda f: float(spline.at(np.array(f))), low, high, epsabs=1e-10, limit=200)[0]
        assert mean == pytest.approx(whole / (high - low), rel=1e-4)


def test_the_mean_of_curves_is_the_mean_at_every_force() -> None:
    each = [fit_monotone(FORCE_N, a + 8 * FORCE_N, np.ones(40), RANGE_N) for a in (1.0, 9.0)]
    np.testing.assert_allclose(mean_spline(each).at(EVERY), (each[0].at(EVERY) + each[1].at(EVERY)) / 2, rtol=1e-12)


def test_a_curve_that_was_stored_is_the_same(tmp_path: Path) -> None:
    spline = fit_monotone(FORCE_N, 5 + 8 * FORCE_N, np.ones(40), RANGE_N)
    artifacts.save(tmp_path / "spline", spline)
    again = artifacts.load(tmp_path / "spline")
    np.testing.assert_array_equal(again.at(EVERY), spline.at(EVERY))


def test_a_single_point_is_refused() -> None:
    with pytest.raises(DataError, match="two points or more") as caught:
        fit_monotone(np.array([1.0]), np.array([2.0]), np.array([1.0]), RANGE_N)
    assert caught.value.found == "1"
