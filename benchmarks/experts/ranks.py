"""Tests of many designs of one shape (d, k, n) in one call."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import special


def kruskal_and_dunn(x: np.ndarray) -> dict[str, Any]:
    """H and p of Kruskal and Wallis, and p of Dunn's pairs by Bonferroni, with mean ranks of ties."""
    d, k, n = x.shape
    flat, size = x.reshape(d, k * n), k * n
    order = np.argsort(flat, axis=1)
    ranks, places = np.empty(flat.shape), np.broadcast_to(np.arange(1.0, size + 1), flat.shape)
    in_order = np.take_along_axis(flat, order, axis=1)
    same = in_order[:, 1:] == in_order[:, :-1]
    tied = np.zeros(d)
    if np.any(same):
        places, tied = _mean_ranks(in_order)
    np.put_along_axis(ranks, order, places, axis=1)
    means = ranks.reshape(d, k, n).mean(axis=2)
    variance = (size * (size + 1) - tied / (size - 1)) / 12
    h = n * np.sum((means - (size + 1) / 2) ** 2, axis=1) / variance
    first, second = np.triu_indices(k, 1)
    z = np.abs(means[:, first] - means[:, second]) / np.sqrt(variance * 2 / n)[:, None]
    return {"H": h, "p": special.chdtrc(k - 1, h), "p Dunn": np.minimum(2 * first.size * special.ndtr(-z), 1)}


def _mean_ranks(in_order: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean ranks of sorted rows, and the sum of t^3 - t over their ties."""
    least = np.array([np.searchsorted(row, row, "left") for row in in_order])
    most = np.array([np.searchsorted(row, row, "right") for row in in_order])
    count = (most - least).astype(float)
    return (least + 1 + most) / 2, np.sum(count**2 - 1, axis=1)


def anova_and_lsd(x: np.ndarray) -> dict[str, Any]:
    """F and p of one-way designs, p and lower ends of the pairs' least significant differences."""
    _, k, n = x.shape
    means = x.mean(axis=2)
    within = np.sum((x - means[..., None]) ** 2, axis=(1, 2)) / (k * (n - 1))
    f = n * means.var(axis=1, ddof=1) / within
    first, second = np.triu_indices(k, 1)
    difference, se = means[:, first] - means[:, second], np.sqrt(within * 2 / n)[:, None]
    df = k * (n - 1)
    p = 2 * special.stdtr(df, -np.abs(difference) / se)
    return {
        "F": f, "p": special.fdtrc(k - 1, df, f), "p LSD": p,
        "low LSD": difference - special.stdtrit(df, 0.975) * se,
    }  # fmt: skip
