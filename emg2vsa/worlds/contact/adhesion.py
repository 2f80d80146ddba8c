"""The force at which a contact without adhesion is as large as one with it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats


def adhesive_force_n(force_n: ArrayLike, adhesion_mj_per_m2: float, tip_radius_mm: float = 20.0) -> Floats:
    """The force at which a contact without adhesion is as large: F + W + sqrt(2 W F + W^2), W = 3 pi w R.

    Johnson, Kendall and Roberts 1971, Proceedings of the Royal Society A 324, 301. The factor in area is the same for
    all specimens, since the modulus cancels. Without adhesion it is F to the last bit; any shape.
    """
    force = np.asarray(force_n, dtype=np.float64)
    if adhesion_mj_per_m2 == 0:
        return force
    pull_n = 3 * math.pi * adhesion_mj_per_m2 * tip_radius_mm * 1e-6
    return np.asarray(force + pull_n + np.sqrt(2 * pull_n * force + pull_n**2), dtype=np.float64)


def adhesive_force_of_one_n(force_n: float, adhesion_mj_per_m2: float, tip_radius_mm: float = 20.0) -> float:
    """`adhesive_force_n` of a single contact, to the last bit, in plain numbers: far quicker."""
    if adhesion_mj_per_m2 == 0:
        return force_n
    pull_n = 3 * math.pi * adhesion_mj_per_m2 * tip_radius_mm * 1e-6
    return force_n + pull_n + math.sqrt(2 * pull_n * force_n + pull_n**2)
