"""The kinesthetic cue of a press: how fast the force rises as the probe goes in."""

from __future__ import annotations

import numpy as np

from emg2vsa.arrays import Floats

_LEAST_ROWS = 5


def indentation_slope(force_n: Floats, depth_mm: Floats, from_n: float) -> tuple[float, Floats, Floats]:
    """Slope of force over travel of the probe, N/mm, with force (K,) and travel since ``from_n`` (K,), mm.

    Travel is regressed on force, and the slope inverted: the error is in the encoder's coarse steps (0.09 degrees), and
    what enters is the mean compliance of sensor and specimen in series over the same forces for every press. NaN where
    the loading phase is too short or the probe does not go in.
    """
    known = np.isfinite(force_n) & np.isfinite(depth_mm)
    force, depth = force_n[known], depth_mm[known]
    first = int(np.argmax(force >= from_n)) if np.any(force >= from_n) else force.size
    force, depth = force[first:], depth[first:]
    if force.size < _LEAST_ROWS or np.ptp(force) == 0:
        return np.nan, force, depth
    centred = force - force.mean()
    mm_per_n = float(centred @ depth / (centred @ centred))
    return (1 / mm_per_n if mm_per_n > 0 else np.nan), force, depth - depth[0]
