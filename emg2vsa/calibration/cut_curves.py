"""Curves of area over force, cut at a force: the slope up to there."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats

_POINTS = 33  # of the force axis, through which the straight line goes


def cut_rates(force_n: ArrayLike, area: ArrayLike, start_n: float, stop_n: Floats) -> Floats:
    """Slope (G,) of the line through A(F) from ``start_n`` to each of ``stop_n`` (G,); NaN where the press ends before.

    Frames below an earlier force are left out: going down, a contact keeps more of its area than it had.
    """
    force, areas = rising(np.asarray(force_n, dtype=np.float64), np.asarray(area, dtype=np.float64))
    rates = np.full(stop_n.shape, np.nan)
    if force.size < 2 or force[0] > start_n:
        return rates
    unit = np.linspace(-0.5, 0.5, _POINTS)
    reached = stop_n <= force[-1]
    length = stop_n[reached] - start_n
    at = start_n + length[:, None] * (unit + 0.5)
    rates[reached] = np.interp(at, force, areas) @ unit / (unit @ unit) / length
    return rates


def rising(force_n: Floats, area: Floats) -> tuple[Floats, Floats]:
    """The frames whose force is larger than every force before."""
    known = np.isfinite(force_n) & np.isfinite(area)
    force, areas = force_n[known], area[known]
    before = np.maximum.accumulate(np.concatenate([[-np.inf], force]))[:-1]
    return force[force > before], areas[force > before]
