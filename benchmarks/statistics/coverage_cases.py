"""Intervals of b on simulated presses: what the choices of points and weights promise, and what they hold."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from scipy import signal, stats

from benchmarks.bench.case import Case, Size, Way
from emg2vsa.curves.force_bins import bin_edges
from emg2vsa.curves.press_fits import fit_presses
from emg2vsa.settings import FitSettings

A_V, B_V = 30e-6, 15e-6
FS_HZ, DURATION_S = 1000, 2.5
WAYS = {
    "bins, weighted (default)": FitSettings(),
    "bins, robust": FitSettings(robust=True),
    "bins, unweighted": FitSettings(weights="none"),
    "samples at 100 Hz": FitSettings(points="samples", weights="none"),
}
Interval = tuple[np.ndarray, np.ndarray]
"Low and high of b, V, one press each."


def coverage_cases(size: Size) -> Iterator[Case]:
    """Envelopes of Gaussian carriers on a ramp of force, whose samples are correlated."""
    n = size.pick(20, 1000)
    force_n, v = simulate(n)
    slow_n, slow_v = force_n[:, ::10], v[:, ::10]
    ways = [
        Way("emg2vsa", f"fit_presses, {name}", _fitted(slow_n, slow_v, settings), "equal")
        for name, settings in WAYS.items()
    ]
    ways.append(Way("scipy", "linregress on samples at 1000 Hz, loop", lambda: _linregress(force_n, v), "as used"))
    chance = 100 * np.sqrt(0.95 * 0.05 / n)
    yield Case(
        f"95 % intervals of b of {n} presses",
        n,
        "presses",
        tuple(ways),
        _coverage_error,
        "points of coverage off 95 %",
        f"how many of {n} intervals hold the true b; chance alone is {chance:.1f} points",
    )


def simulate(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Force (n, 2500) and activity of presses of 2.5 s: carriers of two muscles, 60 to 40, FIR envelope, no noise."""
    rng = np.random.default_rng(3)
    n_samples, edge = int(DURATION_S * FS_HZ), FS_HZ // 2
    force_n = 0.5 + 6.5 * np.arange(-edge, n_samples + edge) / (n_samples - 1)
    level_v = A_V + B_V * np.log(np.maximum(force_n, 0.2))
    taps = signal.firwin(51, 20, fs=FS_HZ)
    spectrum = signal.butter(2, (20, 150), "bandpass", fs=FS_HZ, output="sos")
    v = np.zeros((n, level_v.size))
    for share in (0.4, 0.6):
        carrier = signal.sosfilt(spectrum, rng.standard_normal((n, level_v.size + FS_HZ)), axis=1)[:, FS_HZ:]
        emg = share * level_v * carrier / carrier.std()
        v += np.sqrt(np.pi / 2) * signal.oaconvolve(np.abs(emg), taps[None], mode="same", axes=1)
    return np.tile(force_n[edge:-edge], (n, 1)), v[:, edge:-edge]


def _fitted(force_n: np.ndarray, v: np.ndarray, settings: FitSettings) -> Callable[[], Interval]:
    flat_n, flat_v, offsets = force_n.ravel(), v.ravel(), np.arange(len(v) + 1) * v.shape[1]
    edges = bin_edges(0.5, 7, 0.3)

    def run() -> Interval:
        found = fit_presses(flat_n, flat_v, offsets, edges, settings).reported
        return found.b_lo, found.b_hi

    return run


def _linregress(force_n: np.ndarray, v: np.ndarray) -> Interval:
    fits = [stats.linregress(np.log(x), y) for x, y in zip(force_n, v, strict=True)]
    reach = stats.t.ppf(0.975, v.shape[1] - 2) * np.array([fit.stderr for fit in fits])
    slope = np.array([fit.slope for fit in fits])
    return slope - reach, slope + reach


def _coverage_error(found: Interval) -> float:
    low, high = found
    return 100 * abs(float(np.mean((low < B_V) & (high > B_V))) - 0.95)
