"""True co-contraction as a function of force: equation (6) in the window, a smooth return to rest tone below it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import SettingError

FloatArray = NDArray[np.float64]

JOIN_SHARE = 0.6
"The logarithm ends at this share of the lower force of the window (0.3 N of 0.5 N)."
REST_SHARE = 0.2
"Rest tone, as a share of the co-contraction where the logarithm ends."


def true_cocontraction_v(force_n: FloatArray, a_v: float, b_v: float, lower_n: float) -> FloatArray:
    """v = a + b ln F for F >= 0.6 ``lower_n``; below, a power of F that joins it with equal value and slope.

    force_n : (n,) true force, not negative. Returns (n,) volts; at zero force a rest tone, a fifth of the joint value.
    """
    join_n, join_v = logarithm_end(a_v, b_v, lower_n)
    rest_v = REST_SHARE * join_v
    exponent = b_v / (join_v - rest_v)
    below = rest_v + (join_v - rest_v) * (np.minimum(force_n, join_n) / join_n) ** exponent
    return np.where(force_n >= join_n, a_v + b_v * np.log(np.maximum(force_n, join_n)), below)


def logarithm_end(a_v: float, b_v: float, lower_n: float) -> tuple[float, float]:
    """Force and co-contraction at which the logarithm ends."""
    join_n = JOIN_SHARE * lower_n
    return join_n, a_v + b_v * math.log(join_n)


def check_coefficients(where: str, a_v: float, b_v: float, lower_n: float) -> None:
    """Refuse a logarithm that is not rising, or not positive where it ends."""
    join_n, join_v = logarithm_end(a_v, b_v, lower_n)
    if not (b_v > 0 and join_v > 0):
        raise SettingError(
            where,
            wanted=f"b_v > 0 and a_v + b_v ln({join_n:g} N) > 0, so that EMG rises with force and stays positive",
            found=f"a_v = {a_v:g}, b_v = {b_v:g}, which give {join_v:.3g} V at {join_n:g} N",
            do="Raise a_v or lower b_v.",
        )
