"""Order statistics of all differences between two samples, without writing all of them down where they are many."""

from __future__ import annotations

import numpy as np

from emg2vsa.arrays import Floats, Ints

_FEW = 1 << 14
_BISECTIONS = 200


def differences_at(left: Floats, right: Floats, places: Ints) -> Floats:
    """Differences left minus right at ``places`` (p, d, q) of their ascending order, for pairs (d, q, n); NaN absent.

    A place outside the differences of a pair takes the nearest.
    """
    d, q, n = left.shape
    if n * right.shape[2] <= _FEW:
        ordered = np.sort(
            (left[..., :, None] - right[..., None, :]).reshape(d, q, n * right.shape[2]), axis=2
        )  # NaN last
        index = np.clip(places, 0, max(ordered.shape[2] - 1, 0))
        return np.stack([np.take_along_axis(ordered, at[..., None], axis=2)[..., 0] for at in index])
    found = np.full(places.shape, np.nan)
    for i, j in np.ndindex(d, q):
        x, y = (np.sort(side[i, j][~np.isnan(side[i, j])]) for side in (left, right))
        if x.size and y.size:
            found[:, i, j] = [_at(x, y, int(np.clip(at, 0, x.size * y.size - 1))) for at in places[:, i, j]]
    return found


def _at(x: Floats, y: Floats, place: int) -> float:
    """The difference with ``place`` smaller ones, by bisection: how many are up to v takes one search a value."""
    low, high = x[0] - y[-1], x[-1] - y[0]
    for _ in range(_BISECTIONS):
        middle = low / 2 + high / 2
        if not low < middle < high:
            break
        low, high = (low, middle) if _up_to(x, y, middle) > place else (middle, high)
    value = low if _up_to(x, y, low) > place else high
    # the search rounds x - v: back to the nearest of the differences themselves
    above = np.searchsorted(y, x - value, side="left")
    near = np.concatenate([x - y[np.maximum(above - 1, 0)], x - y[np.minimum(above, y.size - 1)]])
    return float(near[np.argmin(np.abs(near - value))])


def _up_to(x: Floats, y: Floats, v: float) -> int:
    """How many differences x - y are at most v."""
    return int(np.sum(y.size - np.searchsorted(y, x - v, side="left")))
