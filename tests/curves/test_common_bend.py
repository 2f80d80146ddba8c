"""A curve that the presses share is no noise of theirs; what is of one press alone, or slower than a press, is."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from emg2vsa.arrays import Floats
from emg2vsa.curves.force_bins import bin_edges
from emg2vsa.curves.logarithmic import LogFit
from emg2vsa.curves.press_fits import common_bend, fit_presses
from emg2vsa.settings import FitSettings

SAMPLES = 1000
FORCE_N = np.linspace(0.5, 7, SAMPLES)
EDGES_N = bin_edges(0.5, 7, 0.3)
LOGARITHM, LINE = 30 + 15 * np.log(FORCE_N), 5 + 8 * FORCE_N


def recorded(curve: Floats, presses: int, seed: int, noise: float = 0.2) -> Floats:
    """Levels (presses, SAMPLES) with the noise of an envelope, about as long as a bin."""
    white = np.random.default_rng(seed).standard_normal((presses, SAMPLES + 500))
    slow = signal.lfilter([np.sqrt(1 - 0.95**2)], [1, -0.95], white, axis=1)[:, 500:]
    return np.asarray(curve * (1 + noise * slow))


def fitted(v: Floats, together: bool = True) -> LogFit:
    """All presses as one recording, or the first alone."""
    v = v if together else v[:1]
    offsets = SAMPLES * np.arange(len(v) + 1)
    return fit_presses(np.tile(FORCE_N, len(v)), v.ravel(), offsets, EDGES_N, FitSettings()).reported


def half_widths(fit: LogFit) -> Floats:
    return np.asarray((fit.b_hi - fit.b_lo) / 2)


@pytest.mark.parametrize("curve", [LOGARITHM, LINE], ids=["logarithm", "line"])
def test_the_interval_is_that_of_the_best_line(curve: Floats) -> None:
    truth = fitted(np.stack([curve] * 2)).b[0]
    fits = [fitted(recorded(curve, 8, seed)) for seed in range(40)]
    low, high, b = (np.concatenate([getattr(fit, name) for fit in fits]) for name in ("b_lo", "b_hi", "b"))
    assert np.mean((low <= truth) & (high >= truth)) > 0.92
    assert np.median(high - low) / 2 < 4 * b.std()


def test_one_press_cannot_tell_noise_from_the_curve() -> None:
    v = recorded(LINE, 8, 0)
    together, alone = fitted(v), fitted(v, together=False)
    assert alone.b[0] == together.b[0]
    assert half_widths(alone)[0] > 2 * half_widths(together)[0]


def test_misfit_of_one_press_alone_stays() -> None:
    v = recorded(LINE, 8, 1, noise=0.1)
    plain = half_widths(fitted(v))
    v[0] *= (20 - 4 * FORCE_N + FORCE_N**2) / LINE
    odd = half_widths(fitted(v))
    assert odd[0] > 3 * plain[0]


def test_samples_that_are_left_out_leave_the_curve() -> None:
    v = recorded(LINE, 8, 0)
    whole = half_widths(fitted(v))
    v[2, 400:450] = np.nan
    np.testing.assert_allclose(half_widths(fitted(v)), whole, rtol=0.2)


def test_what_is_slower_than_a_press_stays() -> None:
    """Each press has a level of its own: the scatter of b shows it, the residuals about the curve do not."""
    levels = np.exp(0.05 * np.random.default_rng(3).standard_normal((8, 1)))
    v = recorded(LINE, 8, 2, noise=0.02)
    steady, fit = fitted(v), fitted(v * levels)
    sd = fit.b.std(ddof=1)
    assert sd > 2 * steady.b_se.max()
    assert np.all((fit.b_se > 0.999 * sd) & (half_widths(fit) > 2.36 * sd))


def test_a_logarithm_has_no_bend() -> None:
    """Each of two terms in a thousand."""
    bent = 0
    for seed in range(100):
        v = recorded(LOGARITHM, 6, seed)
        force = np.tile(FORCE_N, (6, 1))
        bent += bool(np.any(common_bend(force, v, np.tile(LOGARITHM, (6, 1)), EDGES_N)))
    assert bent <= 2


def test_the_bend_is_that_of_the_curve() -> None:
    """A polynomial of third order in ln F is met exactly, and silent presses have none."""
    z = 2 * np.log(FORCE_N / 0.5) / np.log(14) - 1
    curve = (
        30
        + 10 * z
        + 4 * np.polynomial.legendre.legval(z, [0, 0, 1])
        - 2 * np.polynomial.legendre.legval(z, [0] * 3 + [1])
    )
    sizes = np.array([[1.0], [1.5], [0.0], [0.7]])
    force, v = np.tile(FORCE_N, (4, 1)), sizes * curve
    level = np.where(sizes > 0, v, 1.0)
    rough = v * (1 + 1e-6 * np.random.default_rng(0).standard_normal(v.shape))
    np.testing.assert_allclose(common_bend(force, rough, level, EDGES_N), sizes * (curve - 30 - 10 * z), atol=1e-3)
