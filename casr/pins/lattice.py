"""Who is next to whom: nearest neighbours and pitch of a set of pins."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def nearest_pins(points_px: NDArray[np.float64], k: int) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Distance (N, k) px and row number (N, k) of the ``k`` nearest other pins, nearest first; k falls to N - 1."""
    k = max(min(k, len(points_px) - 1), 0)
    distance = pairwise_px(points_px, points_px)
    np.fill_diagonal(distance, np.inf)
    order = np.argsort(distance, axis=1, kind="stable")[:, :k]
    return np.take_along_axis(distance, order, axis=1), order


def pairwise_px(a_px: NDArray[np.float64], b_px: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance (N, M) px of every point of ``a_px`` (N, 2) to every point of ``b_px`` (M, 2)."""
    distance: NDArray[np.float64] = np.hypot(a_px[:, None, 0] - b_px[:, 0], a_px[:, None, 1] - b_px[:, 1])
    return distance


def pin_pitch_px(centroids_px: NDArray[np.float64]) -> float:
    """Pin spacing: median distance to the nearest pin, px; NaN rows are left out; NaN below two pins."""
    points = np.asarray(centroids_px, float)
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) < 2:
        return float("nan")
    return float(np.median(nearest_pins(points, 1)[0]))
