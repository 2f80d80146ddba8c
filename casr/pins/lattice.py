"""Who is next to whom: nearest neighbours and pitch of a set of pins."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def nearest_pins(points_px: NDArray[np.float64], k: int) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Distance (N, k) px and row number (N, k) of the ``k`` nearest other pins, nearest first, of two or
    more; k falls to N - 1."""
    k = min(k, len(points_px) - 1)
    squared = squared_distance(points_px, points_px)
    np.fill_diagonal(squared, np.inf)
    near = np.argpartition(squared, k - 1, axis=1)[:, :k]
    near_squared = np.take_along_axis(squared, near, axis=1)
    order = np.argsort(near_squared, axis=1, kind="stable")
    return np.sqrt(np.take_along_axis(near_squared, order, axis=1)), np.take_along_axis(near, order, axis=1)


def squared_distance(a_px: NDArray[np.float64], b_px: NDArray[np.float64]) -> NDArray[np.float64]:
    """Squared distance (N, M) px² of every point of ``a_px`` (N, 2) to every point of ``b_px`` (M, 2)."""
    dx, dy = a_px[:, None, 0] - b_px[:, 0], a_px[:, None, 1] - b_px[:, 1]
    squared: NDArray[np.float64] = dx * dx + dy * dy
    return squared


def pin_pitch_px(centroids_px: NDArray[np.float64]) -> float:
    """Pin spacing: median distance to the nearest pin, px; NaN rows are left out; NaN below two pins."""
    points = np.asarray(centroids_px, float)
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) < 2:
        return float("nan")
    return float(np.median(nearest_pins(points, 1)[0]))
