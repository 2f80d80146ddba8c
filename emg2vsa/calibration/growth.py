"""The power by which the contact grows with force, as the presses themselves show it, and what it means for the law.

If the area depends on F/E* alone, as it must in any elastic contact that one modulus describes, then A ~ F^p is
A ~ (F/E*)^p: the score goes as E*^(-p), and 1/E* as CASR^(1/p). Hertz has p = 2/3. The stiffness of a round contact is
2 E* sqrt(A/pi) whatever the shape of the bodies (Pharr, Oliver and Brotzen 1992, Journal of Materials Research 7, 613),
so that the indentation goes as F^(1 - p/2) E*^(p/2 - 1), and 1/E* as the millimetres per newton to the power of
1/(1 - p/2).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from emg2vsa.calibration.forms import HERTZ
from emg2vsa.runs import RunScores

_LEAST_FRAMES = 3
_MOST_POWER = 2.0  # a contact growing faster would not resist at all


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


def casr_exponent(power: float) -> float:
    """Exponent of CASR in the compliance law for a contact that grows as F^power; Hertz's where it is not known."""
    return 1 / power if power > 0 else HERTZ


def indentation_exponent(power: float) -> float:
    """The same of millimetres per newton."""
    return 1 / (1 - power / 2) if 0 < power < _MOST_POWER else HERTZ
