"""Plate indentation: simulated specimens whose stiffness and contact are known, and trials without an answer."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import optimize, stats

from emg2vsa.curves.plate import fit_hooke
from emg2vsa.errors import DataError


def trials(seed: int, d: int = 1, n: int = 150, noise: float = 0.1, offset: float = 0.1) -> tuple[np.ndarray, ...]:
    """Indentation mm, force N, kappa N/mm, contact mm."""
    rng = np.random.default_rng(seed)
    kappa, contact = rng.uniform(1, 8, (d, 1)), rng.uniform(0.3, 2, (d, 1))
    x = np.broadcast_to(np.linspace(0, 4, n), (d, n))
    force = offset + kappa * np.maximum(x - contact, 0) + noise * rng.standard_normal((d, n))
    return x, force, kappa[:, 0], contact[:, 0]


@pytest.mark.parametrize("noise", [0.02, 0.1, 0.2])
def test_errors_are_as_large_as_stated(noise: float) -> None:
    x, force, kappa, contact = trials(1, d=2000, noise=noise)
    fit = fit_hooke(x, force)
    score = (fit.kappa - kappa) / fit.kappa_se
    assert abs(np.mean(score)) < 0.15
    assert 0.9 < np.std(score) < 1.12
    assert np.mean(np.abs(score) > 4) < 0.005
    assert abs(np.median(fit.contact - contact)) < 0.1 * noise


def test_a_trial_that_starts_in_contact_is_one_line() -> None:
    x, _, kappa, contact = trials(2, d=500)
    force = kappa[:, None] * (x + contact[:, None]) + 0.1 * np.random.default_rng(2).standard_normal(x.shape)
    fit = fit_hooke(x, force)
    assert np.mean(fit.n_rest == 0) > 0.995
    alone = int(np.flatnonzero(fit.n_rest == 0)[0])
    peer = stats.linregress(x[alone], force[alone])
    np.testing.assert_allclose([fit.kappa[alone], fit.kappa_se[alone]], [peer.slope, peer.stderr], rtol=1e-11)
    np.testing.assert_allclose(fit.contact[alone], -peer.intercept / peer.slope, rtol=1e-11)


def test_contact_is_that_of_the_best_joined_curve() -> None:
    x, force, _, _ = trials(3, noise=0.05)
    fit = fit_hooke(x, force)

    def curve(x: np.ndarray, rest: float, kappa: float, contact: float) -> np.ndarray:
        return rest + kappa * np.maximum(x - contact, 0)

    peer, _ = optimize.curve_fit(curve, x[0], force[0], [0.1, fit.kappa[0], fit.contact[0]], method="dogbox")
    np.testing.assert_allclose([fit.kappa[0], fit.contact[0]], peer[1:], rtol=0.01, atol=0.005)


def test_noise_free_trial_is_exact() -> None:
    x = np.arange(41) / 8
    fit = fit_hooke(x, 5 * np.maximum(x - 1.5, 0))
    np.testing.assert_allclose([fit.kappa[0], fit.contact[0], fit.adj_r2[0]], [5, 1.5, 1], rtol=1e-14)
    assert fit.kappa_se[0] < 1e-13


@given(st.integers(0, 2**32 - 1), st.floats(-5, 5), st.floats(1e-3, 1e3), st.floats(-10, 10))
@settings(max_examples=30, deadline=None)
def test_origin_units_order_and_padding(seed: int, shift: float, unit: float, offset: float) -> None:
    x, force, _, _ = trials(seed)
    order = np.random.default_rng(seed).permutation(152)
    longer_x, longer_f = np.append(x[0], [np.nan, 9.0])[order], np.append(force[0], [1.0, np.nan])[order]
    fit, moved = fit_hooke(x, force), fit_hooke(unit * (longer_x + shift), longer_f + offset)
    np.testing.assert_allclose(moved.kappa * unit, fit.kappa, rtol=1e-8)
    np.testing.assert_allclose(moved.contact / unit, fit.contact + shift, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(moved.kappa_se * unit, fit.kappa_se, rtol=1e-7)
    np.testing.assert_allclose(moved.adj_r2, fit.adj_r2, rtol=1e-8)
    assert moved.n[0] + moved.n_rest[0] == 150


@pytest.mark.parametrize("scale", [1e-300, 1e-150, 1e150, 1e300])
def test_extreme_scales(scale: float) -> None:
    x, force, _, _ = trials(4)
    x, force = x / 4, force / 40
    fit, tall, wide = fit_hooke(x, force), fit_hooke(x, force * scale), fit_hooke(x * scale, force)
    np.testing.assert_allclose([tall.kappa / scale, tall.kappa_se / scale], [fit.kappa, fit.kappa_se], rtol=1e-11)
    np.testing.assert_allclose(tall.contact, fit.contact, rtol=1e-11)
    np.testing.assert_allclose([wide.contact / scale, wide.kappa * scale], [fit.contact, fit.kappa], rtol=1e-11)


@pytest.mark.parametrize(
    ("x", "force"),
    [
        ([], []),
        ([1.0], [2.0]),
        ([1.0, 1.0, 1.0], [1.0, 2.0, 3.0]),
        ([np.nan, np.inf, 1.0], [1.0, 2.0, 3.0]),
        ([1.0, 2.0, 3.0, 4.0], [-1.0, -2.0, -3.0, -4.0]),
        ([1.0, 2.0, 3.0, 4.0], [2.0, 2.0, 2.0, 2.0]),
    ],
)
def test_trials_without_a_rise_have_no_stiffness_above_zero(x: list[float], force: list[float]) -> None:
    assert not fit_hooke(x, force).kappa[0] > 0


def test_wrong_shapes_are_named() -> None:
    with pytest.raises(DataError, match="Hooke fit"):
        fit_hooke(np.ones(3), np.ones((2, 4)))
