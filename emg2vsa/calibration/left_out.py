"""Does the law hold? Every known specimen estimated from the others, and its kappa held against the interval."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.calibration.calibrate import Calibration, calibrate
from emg2vsa.calibration.forms import eta_of
from emg2vsa.calibration.repeats import repeat_interval


@dataclass(frozen=True)
class LeftOut:
    """d calibrations of S specimens; kappa, low, high : (d, S) N/mm as the others say; p : (d, S) of the known kappa.

    Two specimens determine two parameters, so with three specimens the three p judge one and the same misfit.
    """

    kappa: Floats
    low: Floats
    high: Floats
    p: Floats

    @property
    def law_p(self) -> Floats:
        """(d,) p of the law: the smallest of S, with Bonferroni's factor; NaN below three specimens."""
        tested = np.count_nonzero(np.isfinite(self.p), axis=1)
        smallest = np.min(np.where(np.isfinite(self.p), self.p, 1.0), axis=1)
        return np.where(tested > 0, np.minimum(tested * smallest, 1.0), np.nan)


def left_out(calibration: Calibration) -> LeftOut:
    """Leave out one specimen after the other; needs three specimens, else all is NaN."""
    d, s, _ = calibration.casr.shape
    if s < 3:
        nothing = np.full((d, s), np.nan)
        return LeftOut(nothing, nothing, nothing, nothing)
    columns = [_one(calibration, j) for j in range(s)]
    return LeftOut(*(np.stack(column, axis=1) for column in zip(*columns, strict=True)))


def _one(calibration: Calibration, j: int) -> tuple[Floats, Floats, Floats, Floats]:
    others = np.arange(len(calibration.specimens)) != j
    without = calibrate(
        calibration.kappa[:, others],
        calibration.casr[:, others],
        calibration.settings,
        casr_unit=calibration.casr_unit,
        kappa_se=calibration.kappa_se[:, others],
        mount_share=calibration.mount_share,
        other_exponent=calibration.other_exponent,
    )
    found = repeat_interval(without, calibration.casr[:, j])
    return found.kappa, found.low, found.high, found.p_of(eta_of(calibration.settings.law, calibration.kappa[:, j]))
