"""Tests of many designs of one shape (d, k, n) in one call."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import special


def kruskal_and_dunn(x: np.ndarray) -> dict[str, Any]:
    """H and p of Kruskal and Wallis, and p of Dunn's pairs by Bonferroni, with mean ranks of ties."""
    _refuse_gaps(x)
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
    difference = means[:, first] - means[:, second]
    z = difference / np.sqrt(variance * 2 / n)[:, None]
    return {
        "H": h, "p": special.chdtrc(k - 1, h), "epsilon2": h / (size - 1), "mean ranks": means,
        "difference": difference, "z": z, "p Dunn": np.minimum(2 * first.size * special.ndtr(-np.abs(z)), 1),
    }  # fmt: skip


def _refuse_gaps(x: np.ndarray) -> None:
    if not np.isfinite(x).all():
        raise ValueError("every value must be a number")


def _mean_ranks(in_order: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean ranks of sorted rows, and the sum of t^3 - t over their ties."""
    least = np.array([np.searchsorted(row, row, "left") for row in in_order])
    most = np.array([np.searchsorted(row, row, "right") for row in in_order])
    count = (most - least).astype(float)
    return (least + 1 + most) / 2, np.sum(count**2 - 1, axis=1)


def anova_and_lsd(x: np.ndarray) -> dict[str, Any]:
    """F, p, eta2 and SD of one-way designs, and t, p and intervals of the pairs' least significant differences."""
    _refuse_gaps(x)
    _, k, n = x.shape
    means, df = x.mean(axis=2), k * (n - 1)
    squares = np.sum((x - means[..., None]) ** 2, axis=(1, 2))
    between, within = n * (k - 1) * means.var(axis=1, ddof=1), squares / df
    f = between / (k - 1) / within
    first, second = np.triu_indices(k, 1)
    difference, se = means[:, first] - means[:, second], np.sqrt(within * 2 / n)[:, None]
    t, reach = difference / se, special.stdtrit(df, 0.975) * se
    return {
        "F": f, "p": special.fdtrc(k - 1, df, f), "eta2": between / (between + squares), "sd": np.sqrt(within),
        "means": means, "difference": difference, "t": t, "p LSD": 2 * special.stdtr(df, -np.abs(t)),
        "low LSD": difference - reach, "high LSD": difference + reach,
    }  # fmt: skip
