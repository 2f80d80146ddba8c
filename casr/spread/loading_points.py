"""Frames to points (force, area) on a rising force axis."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.errors import FramesError

Points = tuple[NDArray[np.float64], NDArray[np.float64], tuple[str, ...]]
"""Area (n,), force (n,) in N, and what was done to get there."""


DIP_N = 0.2
"""Depth of a fall of force, N, up to which it is noise: four standard deviations of a frame at 0.05 N."""


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


def outside_dips(area: NDArray[np.float64], force_n: NDArray[np.float64]) -> Points:
    """The frames that lie no more than ``DIP_N`` below an earlier force.

    When the force goes down and up again a contact keeps area that it had (hysteresis); from where the force was
    before it grows on as if nothing had been. Falls within ``DIP_N`` are taken for noise and left to ``pooled``: to
    keep rising frames only would choose those whose force reads too high.
    """
    kept = force_n >= np.maximum.accumulate(force_n) - DIP_N if force_n.size else np.ones(0, dtype=np.bool_)
    lost = int(force_n.size - kept.sum())
    notes = (f"{lost} of {force_n.size} frames in dips of the force deeper than {DIP_N:g} N are left out.",)
    return area[kept], force_n[kept], notes if lost else ()


def pooled(area: NDArray[np.float64], force_n: NDArray[np.float64]) -> Points:
    """Isotonic force: neighbouring frames whose force does not rise become one point, their mean force and mean area.

    The pools are those of the pool-adjacent-violators algorithm (Ayer et al. 1955), so the forces come out strictly
    rising and nearest to the measured ones in the least-squares sense.
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
