"""Mann and Whitney's test of two samples with the shift of Hodges and Lehmann and its interval."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import special

TAIL = 0.025
ENOUGH = 8
"Differences for each value that are written down at the end of a search."


def exact_of_pairs(x: np.ndarray, y: np.ndarray) -> dict[str, Any]:
    """U, exact p, shift and interval of untied samples (..., m) and (..., n), all pairs at once."""
    m, n = x.shape[-1], y.shape[-1]
    differences = np.sort((x[..., :, None] - y[..., None, :]).reshape(*x.shape[:-1], m * n), axis=-1)
    u = np.count_nonzero(differences > 0, axis=-1)
    law = np.ones(1)  # Gauss's binomial: how many orders have each U
    for i in range(1, min(m, n) + 1):
        longer = np.concatenate((law, np.zeros(max(m, n) + i)))
        longer[max(m, n) + i :] -= law
        for k in range(i):  # a division by 1 - q^i
            longer[k::i] = np.cumsum(longer[k::i])
        law = longer[: i * max(m, n) + 1]
    below = np.cumsum(law) / law.sum()
    k = int(np.searchsorted(below, TAIL, side="right")) - 1
    return {
        "u": u, "p": np.minimum(2 * below[np.minimum(u, m * n - u)], 1),
        "shift": np.median(differences, axis=-1), "low": differences[..., k], "high": differences[..., m * n - 1 - k],
    }  # fmt: skip


def of_large(x: np.ndarray, y: np.ndarray) -> dict[str, Any]:
    """U, normal p, shift and interval of two large untied samples."""
    x, y = np.sort(x), np.sort(y)
    m, n = x.size, y.size
    u = int(np.searchsorted(y, x).sum())
    sd = np.sqrt(m * n * (m + n + 1) / 12)
    k = int(np.floor(m * n / 2 + special.ndtri(TAIL) * sd - 0.5))
    middle = [_of_rank(x, y, rank) for rank in sorted({(m * n - 1) // 2, m * n // 2})]
    return {
        "u": u, "p": 2 * special.ndtr(-abs(u - m * n / 2) / sd), "shift": float(np.mean(middle)),
        "low": _of_rank(x, y, k), "high": _of_rank(x, y, m * n - 1 - k),
    }  # fmt: skip


def _of_rank(x: np.ndarray, y: np.ndarray, rank: int) -> float:
    """The difference x - y of a rank: a secant through how many are smaller, until few enough are left to sort."""
    low, high = x[0] - y[-1], np.nextafter(x[-1] - y[0], np.inf)
    few, many = 0, x.size * y.size
    at = x[int((rank + 0.5) / many * x.size)] - y[y.size // 2]
    stuck = 0
    while many - few > ENOUGH * x.size:
        at = at if low < at < high and stuck < 3 else (low + high) / 2
        below = int((y.size - np.searchsorted(y, x - at, side="right")).sum())
        stuck = stuck + 1 if max(below - few, many - below) > 0.9 * (many - few) else 0
        if below <= rank:
            low, few = at, below
        else:
            high, many = at, below
        lean = (x.size * y.size) ** 0.5 * 2  # a little to the far side, so that both ends close in
        goal = rank + (lean if below <= rank else -lean)
        at = low + (high - low) * (goal - few) / (many - few)
    first, last = np.searchsorted(y, x - high, side="right"), np.searchsorted(y, x - low, side="right")
    count = last - first
    inside = np.repeat(x, count) - y[np.arange(count.sum()) - np.repeat(np.cumsum(count) - count - first, count)]
    return float(np.partition(inside, rank - few)[rank - few])
