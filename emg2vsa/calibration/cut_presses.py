"""Presses cut at a force: the score that a press would have had, had it turned back there.

The score of half a press is not the score of a whole one, because A(F) is concave. So known and unknown specimens are
compared over the same forces. A cut press has the mean rate of the power law through its frames, as a whole one has
(casr.spread).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.spread import fit_power_laws
from emg2vsa.arrays import Floats, Ints

STEP_N = 0.2
"Between two forces at which a press is judged."
ROUNDING_N = 1e-6
LEAST_FRAMES = 3
REACH = 0.8
"""Share of a force that a press must have reached for its law to be read there: of 20 frames a second the last lies up
to 0.8 N below the peak."""


def cut_forces(start_n: float, stop_n: float) -> Floats:
    """(G,) forces, N, at which a press is judged, from two steps above ``start_n``; the last is ``stop_n``."""
    count = int((stop_n - start_n) / STEP_N + ROUNDING_N)
    return np.asarray(stop_n - STEP_N * np.arange(max(count - 1, 1), dtype=np.float64)[::-1])


def cut_all(curves: Sequence[Sequence[tuple[Floats, Floats]]], start_n: float, forces_n: Floats) -> Floats:
    """(S, R, G) rates, area/N, of the presses (force in N, area) of each specimen, padded with NaN. forces_n :
    (G,) N."""
    found = np.full((len(curves), max(map(len, curves), default=0), forces_n.size), np.nan)
    for s, each in enumerate(curves):
        for r, (force_n, values) in enumerate(each):
            found[s, r] = cut_rates(force_n, values, start_n, forces_n)
    return found


def cut_rates(force_n: ArrayLike, area: ArrayLike, start_n: float, stop_n: Floats) -> Floats:
    """Mean rate (G,), area/N, from ``start_n`` to each of ``stop_n`` (G,), N, of the power law through the frames up to
    there.

    force_n, area : (T,). NaN where there are fewer than three frames, or none near the force.
    Frames below an earlier force are left out: going down, a contact keeps more of its area than it had.
    """
    force, areas = rising(np.asarray(force_n, dtype=np.float64), np.asarray(area, dtype=np.float64))
    used = (force >= start_n) & (areas > 0)
    force, areas = force[used], areas[used]
    count = np.asarray(np.searchsorted(force, stop_n + ROUNDING_N, side="right"), dtype=np.int64)
    rates = np.full(stop_n.shape, np.nan)
    if (good := _near(force, count, stop_n)).any():
        up_to = np.where(np.arange(force.size) < count[good][:, None], areas, np.nan)
        rates[good] = fit_power_laws(up_to, force).mean_rates(start_n, stop_n[good])
    return rates


def _near(force: Floats, count: Ints, stop_n: Floats) -> NDArray[np.bool_]:
    """(G,) whether ``count`` (G,) frames are enough, and the last of them is near the force."""
    good = np.asarray(count >= LEAST_FRAMES)
    good[good] = force[count[good] - 1] >= REACH * stop_n[good]
    return good


def rising(force_n: Floats, values: Floats) -> tuple[Floats, Floats]:
    """The frames of force (T,), N, and values (T,) whose force is larger than every force before."""
    known = np.isfinite(force_n) & np.isfinite(values)
    force, found = force_n[known], values[known]
    before = np.maximum.accumulate(np.concatenate([[-np.inf], force]))[:-1]
    return force[force > before], found[force > before]
