"""What is wrong with a channel of force as a whole: it holds EMG, returns to zero by itself, or was sampled slowly.

Asked of raw force, before presses are looked for. Limits were set on simulated mishaps (benchmarks/mishaps.py).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from emg2vsa.arrays import Floats, median, quantiles, runs_of, slices, sums_of

FAST_BLOCK_S = 0.025
"What differs within blocks of this length is faster than 20 Hz."
LIKE_EMG, LIKE_FORCE = 0.6, 0.05
"Shares of the variance that are faster: EMG has more than the first, force less than the second."
UPPER, LULLS = 0.4, 3
"A press rises above this share of the way from the median of force up; so many lulls show what follows a release."
RECOVERY_S, RECOVERS, BY_LEVEL = 0.4, 0.03, 0.8
"""After a release, force that is AC-coupled rises within this time by more than this share of its range, and this
share of the variance of that rise is proportional to the level it rises from."""
SMOOTH_S = 0.05
SLOW_HZ, KNOTS, REGULAR, ADJACENT = 20.0, 20, 0.9, 0.7
"""Force below this rate does not follow a press; so many of its bends, and this share of them, lie on a grid, and so
many of those that follow each other are neighbours on it."""
LOOKED_AT_S = 40.0
"So long a piece of force shows its rate."


def exchanged(force: Floats, force_fs_hz: float, muscles: Sequence[str], emg: Sequence[Floats], fs_hz: float) -> str:
    """Which muscle's samples (n,) look like force where force (k,), at ``force_fs_hz``, looks like EMG; else ""."""
    if _fast_share(force, force_fs_hz) < LIKE_EMG:
        return ""
    for muscle, samples in zip(muscles, emg, strict=True):
        if _fast_share(samples, fs_hz) < LIKE_FORCE:
            return f"force looks like EMG, and {muscle} like force; were the two channels exchanged?"
    return ""


def returns_to_zero(force: Floats, fs_hz: float) -> str:
    """Whether raw force (n,) at ``fs_hz``, Hz, recovers from each release as through a high-pass filter, and its time
    constant; or ""."""
    size = max(1, round(SMOOTH_S * fs_hz))
    if force.size < 10 * size:
        return ""
    smooth = sums_of(force[: force.size // size * size].reshape(-1, size)) / size
    step_s = size / fs_hz
    ahead = max(1, round(RECOVERY_S / step_s))
    low, middle, high = quantiles(np.sort(smooth), 0.01, 0.5, 0.99)
    starts, stops = runs_of(smooth > middle + UPPER * (high - middle))
    from_n, rise_n = [], []
    for released, pressed in zip(stops[:-1].tolist(), starts[1:].tolist(), strict=True):
        lull = smooth[released:pressed]
        bottom = int(np.argmin(lull))
        # the next press rises from the level that the first half of the lull led to
        piece = lull[bottom : bottom + max(ahead + 2, (lull.size - bottom) // 2)]
        if piece.size > ahead + 1:
            from_n.append(piece[:-ahead])
            rise_n.append(piece[ahead:] - piece[:-ahead])
    if len(rise_n) < LULLS or median(np.array([rise[0] for rise in rise_n])) < RECOVERS * (high - low):
        return ""
    level, rise = np.concatenate(from_n), np.concatenate(rise_n)
    level, rise = level - level.mean(), rise - rise.mean()
    product, power = float(level @ rise), float((level @ level) * (rise @ rise))
    lost = -product / float(level @ level) if power > 0 else 0.0
    if not 0 < lost < 1 or product**2 < BY_LEVEL * power:
        return ""
    constant_s = -ahead * step_s / np.log1p(-lost)
    return f"force returns to zero by itself, within {constant_s:.2g} s (time constant); is it AC-coupled?"


def sampled_slowly(force: Floats, fs_hz: float) -> Iterator[str]:
    """Note that raw force (n,) was sampled at less than ``SLOW_HZ``, though its file says ``fs_hz``, both in Hz.

    Force that was held, or interpolated, bends on an even grid only.
    """
    if fs_hz < SLOW_HZ:
        yield f"force was sampled at about {fs_hz:.3g} Hz"
        return
    n = min(force.size, round(LOOKED_AT_S * fs_hz))
    begin = (force.size - n) // 2
    bends = np.abs(np.diff(force[begin : begin + n], 2))
    if bends.size < 2 * KNOTS:
        return
    # on a grid of 20 Hz two samples in each twentieth of a second bend at most; the rest is rounding
    share = 1 - 2.5 * SLOW_HZ / fs_hz
    top, at = float(bends.max()), int(share * (bends.size - 1))
    # where that many lie within a quarter of the largest, none is a knot
    if share <= 0 or np.count_nonzero(4 * bends >= top) >= bends.size - at:
        return
    limit = 4 * quantiles(np.partition(bends, (at, at + 1)), share)[0]
    knots = np.flatnonzero(bends > max(limit, 1e-9 * top))
    knots = knots[np.diff(knots, prepend=-2) > 1]
    gaps = np.diff(knots)
    if gaps.size < KNOTS:
        return
    counts = np.bincount(gaps)
    # a grid that falls between samples has gaps of two lengths
    usual = int(np.argmax(counts))
    near = gaps[np.abs(gaps - usual) <= 1]
    grid = float(near.mean())
    # a staircase bends on a grid too, but turns by halves: sampled force bends at nearly every point of it
    if near.size < max(KNOTS, ADJACENT * gaps.size) or fs_hz / grid > SLOW_HZ:
        return
    if np.mean(np.abs(gaps - grid * np.rint(gaps / grid)) <= 1.5) > REGULAR:
        yield f"force was sampled at about {fs_hz / grid:.3g} Hz, and held or interpolated to {fs_hz:.4g} Hz"


def _fast_share(x: Floats, fs_hz: float) -> float:
    """Share of the variance of (n,) samples that lies within blocks; 0 for a constant, and where blocks hold one
    sample.
    """
    size = round(FAST_BLOCK_S * fs_hz)
    if size < 4 or x.size < 4 * size:
        return 0.0
    blocks = x[: x.size // size * size].reshape(-1, size)
    means, within = sums_of(blocks) / size, 0.0
    for part in slices(len(blocks), size):
        apart = (blocks[part] - means[part, None]).ravel()
        within += float(apart @ apart) / blocks.size
    return within / total if (total := within + float(np.var(means))) > 0 else 0.0
