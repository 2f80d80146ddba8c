"""Where a plate first touches: depth with its interval, and the force of rest before it."""

from __future__ import annotations

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.curves.line import fit_line

LEAST, REST = 12, 5
"""Fewest points of a press that says anything, and of the rest before contact."""
_NOISES = 15
"""SDs of the noise over the rest, up to which force tells the contact."""
MAD = 0.6744897501960817
_CHI2 = 3.841458820694124


def first_contact(x: Floats, y: Floats, from_n: float) -> tuple[tuple[float, float, float], float, int]:
    """(depth of first touch, lower and upper end of its 95 % interval), mm, force of rest, N, and points of rest: the
    first ones, or 0.

    x, y : (n,) depth, mm, and force, N, of the loading. from_n : F0, N.
    Up to twice F0 the force is one level, and from the touch on a line and a parabola, neither of which falls; the
    interval is that of the likelihood over the touch. With no rest the force is taken as zero where there is none.
    """
    noise = float(np.median(np.abs(np.diff(y, 2)))) / (MAD * np.sqrt(6))
    up_to = np.median(y[:REST]) + min(2 * from_n, max(_NOISES * noise, 0.1 * from_n))
    risen = y > up_to
    near = min(max(int(np.argmax(risen)) + REST, LEAST), x.size) if risen.any() else x.size
    x, y = x[:near], y[:near]
    step = (x[-1] - x[0]) / 100
    coarse = np.arange(100) * step + x[0]
    gain, _ = _arms(x, y, coarse)
    fine = coarse[int(np.argmax(gain))] + np.linspace(-3, 3, 121) * step
    touch = np.unique(np.r_[coarse, fine[(fine >= x[0]) & (fine < x[-1])]])
    gain, left = _arms(x, y, touch)
    square, longer = left_over(left, y, 4)
    slack = _CHI2 * square / max(x.size - 4, 1) * longer
    likely = touch[gain >= gain.max() - slack]
    low, high = float(likely[0]) - 0.1 * step, float(likely[-1]) + 0.1 * step
    best = float(touch[int(np.argmax(gain))])
    rest_n = int(np.argmax(x >= low))
    if rest_n >= REST:
        return (best, low, high), float(np.mean(y[:rest_n])), rest_n
    kappa = float(fit_line(x[None], y[None]).slope[0])
    start, start_se = force_at_start(x, y)
    if not kappa > 0:
        return (np.nan, np.nan, np.nan), 0.0, 0
    wide = (abs(start) + 2 * start_se) / kappa
    zero = float(x[0]) - start / kappa
    return (zero, zero - wide, max(zero + wide, high)), 0.0, 0


def force_at_start(x: Floats, y: Floats) -> tuple[float, float]:
    """Force at the first of the points x, y (n,) and its standard error, by a line through the first ones."""
    line = fit_line(x[None, :REST] - x[0], y[None, :REST])
    return float(line.intercept[0]), float(line.intercept_se[0])


def _arms(x: Floats, y: Floats, touch: Floats) -> tuple[Floats, Floats]:
    """Sum of squares that level, line and parabola behind each touch (t,) explain, and what the best leaves (n,)."""
    behind = np.maximum(x - touch[:, None], 0.0)
    line, bow = (arm - arm.mean(axis=1, keepdims=True) for arm in (behind, behind * behind))
    centred = y - y.mean()
    ll, bb, lb = (np.sum(a * b, axis=1) for a, b in ((line, line), (bow, bow), (line, bow)))
    ly, by = line @ centred, bow @ centred
    with np.errstate(divide="ignore", invalid="ignore"):
        of_line, of_bow, det = ly / ll, by / bb, ll * bb - lb * lb
        both = np.stack([(bb * ly - lb * by) / det, (ll * by - lb * ly) / det])
        ways = np.stack([
            np.where(of_line > 0, of_line * ly, 0.0),
            np.where(of_bow > 0, of_bow * by, 0.0),
            np.where((both > 0).all(axis=0) & (det > 1e-9 * ll * bb), both[0] * ly + both[1] * by, 0.0),
        ])  # fmt: skip
    ways = np.nan_to_num(ways)
    gain = ways.max(axis=0)
    best = int(np.argmax(gain))
    way = int(np.argmax(ways[:, best]))
    slope = [(of_line[best], 0.0), (0.0, of_bow[best]), tuple(both[:, best])][way]
    return gain, centred - slope[0] * line[best] - slope[1] * bow[best]


def left_over(left: Floats, y: Floats, p: int) -> tuple[float, float]:
    """Sum of squares of what p parameters leave of y, not below rounding, and by how much its autocorrelation (AR 1)
    makes a variance larger."""
    square = max(float(left @ left), np.finfo(np.float64).eps * float(y @ y), np.finfo(np.float64).tiny)
    rho = min(max(float(left[1:] @ left[:-1]) / square + p / y.size, 0.0), 0.98)
    return square, (1 + rho) / (1 - rho)
