"""What an envelope reads without muscle, subtracted in power; and how far what stays moves the slope of a press.

Noise of the amplifier adds in power: an envelope m over a floor c shows a level of sqrt(m^2 - c^2). Taken sample by
sample that would be biased, because the envelope itself is noisy and the root is curved. The level of a press is
therefore found first, as a parabola in ln F (the square of a + b ln F plus a constant is one), and the samples follow
its tangent.
"""

from __future__ import annotations

import numpy as np

from emg2vsa.arrays import Floats, Ints

MOST_FLOOR = 0.75
"Largest share of the power of a level that is subtracted: what is left is never below half of what was read."


def press_levels(envelopes_v: Floats, force_n: Floats, offsets: Ints) -> Floats:
    """Smooth levels (m, N) of the envelopes (m, N), by force: a parabola in ln F for each press and muscle.

    Weighted by 1 / level^2, since the noise of an envelope grows with its level. Presses of fewer than ten samples, or
    whose force does not change, keep their mean.
    """
    levels = np.empty_like(envelopes_v)
    for begin, end in zip(offsets[:-1].tolist(), offsets[1:].tolist(), strict=True):
        if end > begin:
            levels[:, begin:end] = _parabola(np.log(np.maximum(force_n[begin:end], 1e-9)), envelopes_v[:, begin:end])
    return levels


def _parabola(x: Floats, rows: Floats) -> Floats:
    mean = rows.mean(axis=1, keepdims=True)
    reach = float(np.ptp(x))
    if x.size < 10 or reach < 1e-3:
        return np.broadcast_to(mean, rows.shape)
    u = 2 * (x - x.min()) / reach - 1
    basis = np.stack([np.ones_like(u), u, 1.5 * u * u - 0.5])
    level = np.broadcast_to(mean, rows.shape)
    for _ in range(2):
        weights = 1 / np.maximum(level, 0.1 * mean + 1e-300) ** 2
        normal = np.einsum("in,mn,jn->mij", basis, weights, basis)
        right = np.einsum("in,mn->mi", basis, weights * rows)
        ridge = 1e-9 * np.trace(normal, axis1=1, axis2=2)[:, None, None] * np.eye(3)
        level = np.linalg.solve(normal + ridge, right[..., None])[..., 0] @ basis
    return np.asarray(np.maximum(level, 0.05 * mean))


def subtract_floor(envelopes_v: Floats, levels_v: Floats, floor_v: Floats) -> Floats:
    """Envelopes (m, N) less the floor (m,) in power, along the tangent at their ``press_levels``; never negative."""
    left = np.sqrt(1 - _share(levels_v, floor_v))
    return np.asarray(np.maximum(levels_v * left + (envelopes_v - levels_v) / left, 0.0))


def floor_bias(levels_v: Floats, floor_v: Floats, force_n: Floats, offsets: Ints) -> Floats:
    """By what share (p,) of itself the slope of the sum of muscles changes where the floor (m,) stays in.

    Negative: noise flattens the curve. NaN where it cannot be said.
    """
    without = np.sum(levels_v * np.sqrt(1 - _share(levels_v, floor_v)), axis=0)
    x = np.log(np.maximum(force_n, 1e-9))
    return slope_ratios(x, np.sum(levels_v, axis=0), x, without, without, offsets) - 1


def slope_ratios(x: Floats, y: Floats, true_x: Floats, true_y: Floats, level: Floats, offsets: Ints) -> Floats:
    """Slope of y on x over that of ``true_y`` on ``true_x``, press by press (p,); all (N,), weighted by 1/level^2."""
    ratios = np.full(offsets.size - 1, np.nan)
    for i, (begin, end) in enumerate(zip(offsets[:-1].tolist(), offsets[1:].tolist(), strict=True)):
        cut = slice(begin, end)
        if end - begin >= 10:
            weights = 1 / np.maximum(level[cut], 0.1 * level[cut].max() + 1e-300) ** 2
            true = _slope(true_x[cut], true_y[cut], weights)
            if true != 0:
                ratios[i] = _slope(x[cut], y[cut], weights) / true
    return ratios


def _slope(x: Floats, y: Floats, weights: Floats) -> float:
    weighted = weights * (x - np.average(x, weights=weights))
    across = float(weighted @ x)
    return float(weighted @ y) / across if across > 0 else 0.0


def _share(levels_v: Floats, floor_v: Floats) -> Floats:
    """Share (m, N) of the power of the levels that is floor; 0 where the floor is not known."""
    floor = np.where(np.isfinite(floor_v), floor_v, 0.0)[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(levels_v > 0, (floor / levels_v) ** 2, 0.0)
    return np.asarray(np.minimum(share, MOST_FLOOR))
