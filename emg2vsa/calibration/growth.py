"""The power by which the contact grows with force, as the presses themselves show it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from emg2vsa.runs import RunScores

_LEAST_FRAMES = 3


def growth_power(runs: Sequence[RunScores]) -> float:
    """p of A ~ F^p: the median over presses of the slope of ln A over ln F in the loading phase; NaN without curves.

    In a contact that grows as a power of F/E* the score goes as E*^(-p), whatever p is; Hertz has 2/3.
    """
    powers = []
    for curve in (curve for run in runs for curve in run.curves):
        usable = (curve.force_n > 0) & (curve.area_mm2 > 0)
        if np.count_nonzero(usable) >= _LEAST_FRAMES:
            x, y = np.log(curve.force_n[usable]), np.log(curve.area_mm2[usable])
            x -= x.mean()
            powers.append(float(x @ y / (x @ x)))
    return float(np.median(powers)) if powers else float("nan")
