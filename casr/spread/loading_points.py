"""Frames to points (force, area) on a rising force axis."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.errors import FramesError

Points = tuple[NDArray[np.float64], NDArray[np.float64], tuple[str, ...]]
"""Area (n,), force (n,) in N, and what was done to get there."""


def frames_with_force(area: ArrayLike, force_n: ArrayLike) -> Points:
    """The frames whose force is known; NaN marks an unknown force."""
    area = np.asarray(area, dtype=np.float64).reshape(-1)
    force = np.asarray(force_n, dtype=np.float64).reshape(-1)
    known = ~np.isnan(force)
    if area.size != force.size or not np.isfinite(area[known]).all() or np.isinf(force).any():
        raise FramesError(
            "area and force",
            wanted="a finite area and a force, or NaN, for every frame",
            found=f"{area.size} areas, {force.size} forces, {int(np.isinf(force).sum())} infinite forces and "
            f"{int((~np.isfinite(area)).sum())} areas that are NaN or infinite",
            do="Give the same frames for both.",
        )
    lost = int(known.size - known.sum())
    notes = (f"{lost} of {known.size} frames carry no force and are left out.",) if lost else ()
    return area[known], force[known], notes


def pooled(area: NDArray[np.float64], force_n: NDArray[np.float64]) -> Points:
    """Isotonic force: neighbouring frames whose force does not rise become one point, their mean force and mean area.

    The pools are those of the pool-adjacent-violators algorithm (Ayer et al. 1955), so the forces come out strictly
    rising and nearest to the measured ones in the least-squares sense; a dip of force keeps the area it had there.
    """
    pools: list[tuple[float, float, int]] = []
    for f, a in zip(force_n.tolist(), area.tolist(), strict=True):
        pool = (f, a, 1)
        while pools and pools[-1][0] / pools[-1][2] >= pool[0] / pool[2]:
            last = pools.pop()
            pool = (last[0] + pool[0], last[1] + pool[1], last[2] + pool[2])
        pools.append(pool)
    sums = np.array(pools, dtype=np.float64).reshape(-1, 3)
    merged = force_n.size - len(pools)
    notes = (f"Force does not rise in every frame: {merged} of {force_n.size} frames pooled.",) if merged else ()
    return sums[:, 1] / sums[:, 2], sums[:, 0] / sums[:, 2], notes
