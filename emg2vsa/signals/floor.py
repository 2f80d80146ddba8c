"""What an envelope reads without muscle, subtracted in power; and how far what stays moves the slope of a press.

Noise of the amplifier adds in power: an envelope m over a floor c shows a level of sqrt(m^2 - c^2). Taken sample by
sample that would be biased, because the envelope itself is noisy and the root is curved. The level of a press is
therefore found first, as a parabola in ln F (the square of a + b ln F plus a constant is one), and the samples follow
its tangent.
"""

from __future__ import annotations

import numpy as np

from emg2vsa.arrays import Floats, Ints
from emg2vsa.signals.bias import line_change, means

MOST_FLOOR = 0.75
"Largest share of the power of a level that is subtracted: what is left is never below half of what was read."


_HANKEL = np.add.outer(np.arange(3), np.arange(3))


def press_levels(envelopes_v: Floats, force_n: Floats, offsets: Ints) -> Floats:
    """Smooth levels (m, N) of the envelopes (m, N), by force: a parabola in ln F for each press and muscle.

    Weighted by 1 / level^2, since the noise of an envelope grows with its level. Presses of fewer than ten samples, or
    whose force does not change, keep their mean.
    """
    counts = np.diff(offsets)
    if force_n.size == 0:
        return envelopes_v
    x = np.log(np.maximum(force_n, 1e-9))
    u = x - np.repeat(means(x, offsets), counts)
    reach = means(u * u, offsets)
    plain = (counts < 10) | (reach < 1e-7)
    u /= np.repeat(np.sqrt(np.where(plain, 1.0, reach)), counts)
    powers = np.stack([np.ones_like(u), u, u * u, u**3, u**4])
    mean = np.repeat(means(envelopes_v, offsets), counts, axis=1)
    level, known = mean, mean > 0
    for _ in range(2):
        ratio = np.divide(mean, np.maximum(level, 0.1 * mean), out=np.ones_like(mean), where=known)
        weights = ratio * ratio
        moments = np.moveaxis(means(powers[:, None] * weights, offsets), 0, -1)
        normal = moments[..., _HANKEL] + 1e-9 * moments[..., :1, None] * np.eye(3)
        normal[:, plain] = np.eye(3)
        right = np.moveaxis(means(powers[:3, None] * (weights * envelopes_v), offsets), 0, -1)
        parabola = np.linalg.solve(normal, np.where(plain[:, None], 0.0, right)[..., None])[..., 0]
        level = np.einsum("mnb,bn->mn", np.repeat(parabola, counts, axis=1), powers[:3])
    return np.asarray(np.where(np.repeat(plain, counts), mean, np.maximum(level, 0.05 * mean)))


def subtract_floor(envelopes_v: Floats, levels_v: Floats, floor_v: Floats) -> Floats:
    """Envelopes (m, N) less the floor (m,) in power, along the tangent at their ``press_levels``; never negative.

    Why in power: decision 23.
    """
    left = np.sqrt(1 - _share(levels_v, floor_v))
    return np.asarray(np.maximum(levels_v * left + (envelopes_v - levels_v) / left, 0.0))


def floor_change(levels_v: Floats, floor_v: Floats, force_n: Floats, offsets: Ints) -> tuple[Floats, Floats]:
    """``line_change`` (p,), (p,) of the sum of muscles where a floor (m,) or (m, N) stays in: it bends the curve."""
    without = np.sum(levels_v * np.sqrt(1 - _share(levels_v, floor_v)), axis=0)
    x = np.log(np.maximum(force_n, 1e-9))
    return line_change(x, np.sum(levels_v, axis=0), x, without, without, offsets)


def floor_over_muscle(levels_v: Floats, floor_v: Floats, offsets: Ints) -> Floats:
    """Power (p,) of the floor over that of the muscles, in the mean of a press. levels_v : (m, N) V. floor_v : (m,) or
    (m, N) V."""
    power = levels_v**2
    floor = means(np.sum(power * _share(levels_v, floor_v), axis=0), offsets)
    total = means(np.sum(power, axis=0), offsets)
    return np.divide(floor, total - floor, out=np.zeros_like(floor), where=total > floor)


def _share(levels_v: Floats, floor_v: Floats) -> Floats:
    """Share (m, N) of the power of the levels that is floor; 0 where the floor is not known."""
    floor = np.where(np.isfinite(floor_v), floor_v, 0.0).reshape(len(levels_v), -1)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(levels_v > 0, (floor / levels_v) ** 2, 0.0)
    return np.asarray(np.minimum(share, MOST_FLOOR))
