"""Which law predicts a specimen it has not seen."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats
from emg2vsa.calibration.calibrate import calibrate
from emg2vsa.calibration.laws import LAWS, WAYS
from emg2vsa.settings import CalibrationSettings, Law


@dataclass(frozen=True)
class LawComparison:
    """errors : (laws, d, S) relative error of each specimen's kappa as the others predict it with each law.

    score : (laws, d) root mean square over specimens; NaN where a law is undefined.
    """

    laws: tuple[Law, ...]
    errors: Floats
    score: Floats

    def best(self, i: int = 0) -> Law | None:
        """Law with the smallest score in calibration ``i``; None where no law has one."""
        scores = self.score[:, i]
        return None if np.all(np.isnan(scores)) else self.laws[int(np.nanargmin(scores))]


def compare_laws(
    kappa: ArrayLike, casr: ArrayLike, settings: CalibrationSettings | None = None, *, casr_unit: str
) -> LawComparison:
    """Leave one specimen out with every law; arguments as in ``calibrate``, the law in ``settings`` aside.

    Adjusted R2 cannot tell laws apart on few specimens; predictions of unseen ones can, a little. The outer
    specimens are extrapolations, and weigh most. A law that is not fitted as asked is fitted to errors of CASR.
    """
    settings = settings or CalibrationSettings()
    errors = []
    for law in LAWS:
        minimise = settings.minimise if settings.minimise in WAYS[law] else "casr"
        chosen = dataclasses.replace(settings, law=law, minimise=minimise)
        errors.append(calibrate(kappa, casr, chosen, casr_unit=casr_unit).left_out_error)
    stacked = np.stack(errors)
    with np.errstate(over="ignore", invalid="ignore"):
        return LawComparison(LAWS, stacked, np.sqrt(np.mean(stacked**2, axis=2)))
