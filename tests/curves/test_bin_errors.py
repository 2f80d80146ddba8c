"""Covariance of bin means and what it does to standard errors, against plain linear algebra."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from emg2vsa.curves.force_bins import bin_covariance, bin_means, error_factors
from emg2vsa.curves.logarithmic import fit_log, widen
from emg2vsa.curves.press_fits import fit_presses, shared_number
from emg2vsa.settings import FitSettings

EDGES = np.array([1.0, 2.0, 3.0, 4.0])


def test_covariance_is_that_of_the_means() -> None:
    rng = np.random.default_rng(0)
    lengths = [40, 25]
    force = np.concatenate([rng.uniform(0.8, 4.2, n) for n in lengths])
    offsets = np.array([0, 40, 65])
    bins = bin_means(force, force, offsets, EDGES)
    noise = np.full((2, 40), np.nan)
    memory = np.zeros((2, 40))
    for i, n in enumerate(lengths):
        noise[i, :n] = rng.uniform(0.5, 2, n)
        memory[i, :5] = 0.6 ** np.arange(5)
    covariance = bin_covariance(bins, noise, memory)
    for i, n in enumerate(lengths):
        lag = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
        of_samples = np.where(lag < 5, 0.6**lag, 0) * np.outer(noise[i, :n], noise[i, :n])
        column = bins.column[i, :n]
        means = np.array([(column == b) / np.count_nonzero(column == b) for b in range(3)])
        np.testing.assert_allclose(covariance[i], means @ of_samples @ means.T, rtol=1e-12)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_factors_are_generalised_least_squares_arithmetic(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, w = rng.uniform(-1, 2, 12), rng.uniform(0.1, 3, 12)
    root = rng.standard_normal((12, 12))
    v = root @ root.T
    design = np.column_stack([np.ones(12), x])
    inverse = np.linalg.inv(design.T @ (w[:, None] * design))
    a = inverse @ design.T * w
    m = np.eye(12) - design @ a
    scale = np.trace(np.diag(w) @ m @ v @ m.T) / 10
    factors = np.sqrt(np.diag(a @ v @ a.T) / scale / np.diag(inverse))
    *found, dof = error_factors(x[None], w[None], v[None])
    np.testing.assert_allclose(np.ravel(found), factors, rtol=1e-7)
    share = np.diag(w) @ m @ v @ m.T
    np.testing.assert_allclose(dof, max(np.trace(share) ** 2 / np.trace(share @ share), 1), rtol=1e-7)


def test_independent_points_of_variance_one_over_weight_need_no_correction() -> None:
    rng = np.random.default_rng(1)
    x, w = rng.uniform(-1, 2, (4, 22)), rng.uniform(0.1, 3, (4, 22))
    w[:, 3] = 0
    x[:, 3] = np.nan
    covariance = np.array([np.diag(np.where(row > 0, 1 / np.where(row > 0, row, 1), 7.0)) for row in w])
    for scale in (1, 1e-9):
        *factors, dof = error_factors(x, w, scale * covariance)
        np.testing.assert_allclose(factors, 1, rtol=1e-12)
        np.testing.assert_allclose(dof, 19)


def test_positive_correlation_widens() -> None:
    lag = np.abs(np.subtract.outer(np.arange(22), np.arange(22)))
    x = np.log(np.linspace(0.65, 6.9, 22))[None]
    intercept, slope, dof = error_factors(x, np.ones((1, 22)), (0.4**lag)[None])
    assert intercept[0] > 1.1
    assert slope[0] > 1.1
    assert dof[0] < 18


@pytest.mark.parametrize("used", [0, 1, 2])
def test_too_few_points_leave_the_errors_alone(used: int) -> None:
    w = (np.arange(5) < used).astype(np.float64)[None]
    np.testing.assert_array_equal(np.ravel(error_factors(np.arange(5.0)[None], w, np.eye(5)[None])[:2]), [1, 1])


def test_no_trial() -> None:
    bins = bin_means(np.empty(0), np.empty(0), np.array([0]), EDGES)
    assert bin_covariance(bins, np.empty((0, 0)), np.empty((0, 0))).shape == (0, 3, 3)


def test_widen_keeps_the_estimate() -> None:
    fit = fit_log([1.0, 2.0, 3.0, 4.0], [1.0, 2.0, 2.0, 3.0])
    wide = widen(fit, np.array([2.0]), np.array([3.0]), np.array([2.0]), 0.95)
    assert (wide.a[0], wide.b[0]) == (fit.a[0], fit.b[0])
    np.testing.assert_allclose([wide.a_se, wide.b_se], [2 * fit.a_se, 3 * fit.b_se])
    np.testing.assert_allclose(wide.b_hi - wide.b_lo, 3 * (fit.b_hi - fit.b_lo))


def test_many_presses_with_narrow_bins_are_fitted_as_each_alone() -> None:
    """A thousand bins: the covariances of all seven presses at once would be 56 MB an array."""
    rng, edges, fit = np.random.default_rng(4), np.linspace(0.5, 7, 1001), FitSettings(bin_n=0.0065)
    forces = [np.sort(rng.uniform(0.5, 7, n)) for n in (300, 500, 200, 400, 350, 450, 250)]
    levels = [(20 + 10 * np.log(force)) * (1 + 0.1 * rng.standard_normal(force.size)) for force in forces]
    offsets = np.cumsum([0, *map(len, forces)])
    together = fit_presses(np.concatenate(forces), np.concatenate(levels), offsets, edges, fit).reported
    for i, (force, v) in enumerate(zip(forces, levels, strict=True)):
        alone = fit_presses(force, v, np.array([0, force.size]), edges, fit).reported
        for name in ("b", "a_se", "b_se"):  # the intervals share their degrees of freedom
            assert getattr(together, name)[i] == pytest.approx(getattr(alone, name)[0], rel=1e-9), name


def test_degrees_of_freedom_are_those_of_the_recording() -> None:
    """One value of all presses is worth the same; none is left with one degree of freedom."""
    independent = np.array([40.0, 10.0, np.nan, 20.0])
    n = np.array([200.0, 200.0, 200.0, 400.0])
    np.testing.assert_allclose(shared_number(independent, n), [200, 200, np.nan, 400] / np.cbrt(5 * 20 * 20))
    assert np.isnan(shared_number(np.full(2, np.nan), n[:2])).all()
    rng = np.random.default_rng(3)
    force = np.tile(np.linspace(0.5, 7, 200), 20)
    white = rng.standard_normal((20, 400))
    slow = signal.lfilter([0.14], [1, -0.99], white, axis=1)[:, 200:]
    v = (20 + 10 * np.log(force)) * (1 + 0.3 * slow.ravel())
    fitted = fit_presses(force, v, 200 * np.arange(21), np.linspace(0.5, 7, 22), FitSettings())
    reach = (fitted.reported.b_hi - fitted.reported.b_lo) / (2 * fitted.reported.b_se)
    assert np.all(reach < 4.31)


def test_a_press_alone_has_the_interval_that_it_has_beside_others() -> None:
    """Degrees of freedom of correlated points are no whole numbers."""
    force_n = np.geomspace(0.5, 7, 12)
    two = fit_log(force_n, np.stack([np.log(force_n), force_n]))
    one = fit_log(force_n, np.log(force_n)[None])
    factor, dof = np.full(2, 1.5), np.array([2.9, 7.1])
    beside, alone = widen(two, factor, factor, dof, 0.95), widen(one, factor[:1], factor[:1], dof[:1], 0.95)
    assert (alone.b_lo[0], alone.b_hi[0]) == (beside.b_lo[0], beside.b_hi[0])
