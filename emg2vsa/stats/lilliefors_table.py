"""Quantiles of Lilliefors' D, by simulation."""

from __future__ import annotations

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats, Ints

SIZES = (4, 5, 6, 7, 8, 9, 10, 12, 15, 20, 30, 50, 100, 300)
LEVELS = np.array(
    [0.9999, 0.999, 0.99, 0.97, 0.95, 0.9, 0.85, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.15, 0.1]
    + [a * 10.0**b for b in range(-2, -9, -1) for a in (5, 2, 1)]
)


def largest_d(n: Ints | int) -> Floats:
    """D of a sample with all values equal but one: no sample of n, standardised, has a larger one."""
    return np.asarray(1 - 1 / np.asarray(n) - special.ndtr(-1 / np.sqrt(n)))


def reach(d: Floats, n: Ints | int) -> Floats:
    """-n log(1 - (D / largest D)^2): about proportional to -log p in the tail, whatever n."""
    return np.asarray(-np.asarray(n) * np.log1p(-((d / largest_d(n)) ** 2)))
