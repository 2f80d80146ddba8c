"""Who is next to whom: nearest neighbours and pitch of a set of pins, and one-to-one matches of two sets."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from casr.median import median

NEIGHBOURS = 6  # of a hexagonal lattice; of a square one, those at one pitch and two of the corners
BORDER_GAP_DEG = 150.0


def nearest_pins(points_px: NDArray[np.float64], k: int) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Distance (N, k) px and row number (N, k) of the ``k`` nearest other pins, nearest first, of two or
    more; k falls to N - 1."""
    k = min(k, len(points_px) - 1)
    squared = _squared_distance(points_px, points_px)
    np.fill_diagonal(squared, np.inf)
    near = np.argpartition(squared, k - 1, axis=1)[:, :k]
    near_squared = np.take_along_axis(squared, near, axis=1)
    order = np.argsort(near_squared, axis=1, kind="stable")
    return np.sqrt(np.take_along_axis(near_squared, order, axis=1)), np.take_along_axis(near, order, axis=1)


def at_border(points_px: NDArray[np.float64], beside: NDArray[np.intp]) -> NDArray[np.bool_]:
    """(N,) pins with none beside them over ``BORDER_GAP_DEG``, from the rows (N, k) of each pin's neighbours.

    In any lattice the neighbours of a pin inside stand all around it, also where one of them is missing.
    """
    towards = points_px[beside] - points_px[:, None]
    angle = np.sort(np.arctan2(towards[..., 1], towards[..., 0]), axis=1)
    gap = np.diff(angle, axis=1, append=angle[:, :1] + 2 * np.pi)
    return np.asarray(gap.max(axis=1) > np.deg2rad(BORDER_GAP_DEG))


def _squared_distance(a_px: NDArray[np.float64], b_px: NDArray[np.float64]) -> NDArray[np.float64]:
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
    squared = _squared_distance(points, points)
    np.fill_diagonal(squared, np.inf)
    return float(median(np.sqrt(squared.min(axis=1))))


def match_pins(
    before_px: NDArray[np.float64], after_px: NDArray[np.float64], *, max_distance_px: float | NDArray[np.float64]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Pairs of rows (i_before, i_after) that are each other's nearest pin and at most ``max_distance_px`` apart.

    Where two pins claim the same one, the nearer gets it and the other stays unmatched: a second choice would be
    a guess. Half the pitch is the largest sensible distance. Among equals the lower row wins. NaN rows match nothing.
    The paper's Algorithm 1 compares all pairs instead, which selects nearly every pin.

    Parameters
    ----------
    before_px, after_px : (N, 2), (M, 2) centroids.
    max_distance_px : one distance, or one for each row of ``before_px``.
    """
    rows = np.flatnonzero(np.isfinite(before_px).all(axis=1))
    columns = np.flatnonzero(np.isfinite(after_px).all(axis=1))
    if not rows.size or not columns.size:
        return np.empty(0, np.intp), np.empty(0, np.intp)
    squared = _squared_distance(before_px[rows], after_px[columns])
    nearest = squared.argmin(axis=1)
    own = np.arange(rows.size)
    limit = np.broadcast_to(np.asarray(max_distance_px, float), (len(before_px),))[rows]
    mutual = (squared.argmin(axis=0)[nearest] == own) & (squared[own, nearest] <= limit**2)
    return rows[mutual], columns[nearest[mutual]]
