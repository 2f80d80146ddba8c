"""One-to-one matching of pins between two frames."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from casr.pins.lattice import squared_distance


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
    squared = squared_distance(before_px[rows], after_px[columns])
    nearest = squared.argmin(axis=1)
    own = np.arange(rows.size)
    limit = np.broadcast_to(np.asarray(max_distance_px, float), (len(before_px),))[rows]
    mutual = (squared.argmin(axis=0)[nearest] == own) & (squared[own, nearest] <= limit**2)
    return rows[mutual], columns[nearest[mutual]]
