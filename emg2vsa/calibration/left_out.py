"""Does the law hold? Every known specimen estimated from the others, and its kappa held against the interval.

Where the law is rejected, its intervals are widened until those of the left-out specimens would hold their kappa. The
misfit of a wrong law is largest where it extrapolates, as it does for the outer specimens.

The same with every law says which of them predicts a specimen it has not seen.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from emg2vsa.arrays import Floats
from emg2vsa.calibration.calibrate import Calibration, calibrate
from emg2vsa.calibration.forms import eta_of
from emg2vsa.calibration.laws import LAWS, WAYS
from emg2vsa.calibration.repeats import repeat_interval
from emg2vsa.settings import CalibrationSettings, Law


@dataclass(frozen=True)
class LeftOut:
    """d calibrations of S specimens; kappa : (d, S) N/mm as the others say; p : (d, S) of the known kappa.

    misfit : (d, S) distance of the two on the axis of the law, over half the interval.

    Two specimens determine two parameters, so with three specimens the three p judge one and the same misfit.
    """

    kappa: Floats
    p: Floats
    misfit: Floats

    @cached_property
    def law_p(self) -> Floats:
        """(d,) p of the law: the smallest of S, with Bonferroni's factor; NaN below three specimens."""
        tested = np.count_nonzero(np.isfinite(self.p), axis=1)
        smallest = np.min(np.where(np.isfinite(self.p), self.p, 1.0), axis=1)
        return np.where(tested > 0, np.minimum(tested * smallest, 1.0), np.nan)

    def widening(self, confidence: float) -> Floats:
        """(d,) factor on the standard errors of a law that is rejected; 1 where it is not, or cannot be tested."""
        largest = np.max(np.where(np.isfinite(self.misfit), self.misfit, 1.0), axis=1, initial=1.0)
        return np.where(self.law_p < 1 - confidence, largest, 1.0)


def left_out(calibration: Calibration) -> LeftOut:
    """Leave out one specimen after the other; needs three specimens, else all is NaN.

    When intervals are widened: decision 25.
    """
    d, s, _ = calibration.casr.shape
    if s < 3:
        nothing = np.full((d, s), np.nan)
        return LeftOut(nothing, nothing, nothing)
    columns = [_one(calibration, j) for j in range(s)]
    return LeftOut(*(np.stack(column, axis=1) for column in zip(*columns, strict=True)))


def again(calibration: Calibration, kept: NDArray[np.bool_], law: Law) -> Calibration:
    """The same on these of its specimens (S,), by ``law``; mountings scatter as all specimens show."""
    return calibrate(
        calibration.kappa[:, kept],
        calibration.casr[:, kept],
        _by(calibration.settings, law),
        casr_unit=calibration.casr_unit,
        kappa_se=calibration.kappa_se[:, kept],
        specimen_share=calibration.specimen_share,
        angle_share=calibration.angle_share,
        mountings=calibration.labels[kept],
        scatter=calibration.mounting,
        other_exponent=calibration.other_exponent,
    )


def _by(settings: CalibrationSettings, law: Law) -> CalibrationSettings:
    """Another law; one that is not fitted as asked is fitted to errors of CASR."""
    minimise = settings.minimise if settings.minimise in WAYS[law] else "casr"
    return dataclasses.replace(settings, law=law, minimise=minimise)


def _one(calibration: Calibration, j: int) -> tuple[Floats, Floats, Floats]:
    without = again(calibration, np.arange(len(calibration.specimens)) != j, calibration.settings.law)
    found = repeat_interval(without, calibration.casr[:, j], mountings=calibration.labels[j])
    known = eta_of(calibration.settings.law, calibration.kappa[:, j])
    with np.errstate(invalid="ignore", divide="ignore"):
        reach = special.stdtrit(found.df, 0.5 + 0.5 * calibration.settings.confidence) * found.eta_se
        return found.kappa, found.p_of(known), np.abs(found.eta - known) / reach


@dataclass(frozen=True)
class LawComparison:
    """score : (laws, d) root mean square over specimens of the relative error of kappa as the others predict it.

    NaN where a law is undefined.
    """

    laws: tuple[Law, ...]
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
        errors.append(calibrate(kappa, casr, _by(settings, law), casr_unit=casr_unit).left_out_error)
    stacked = np.stack(errors)
    with np.errstate(over="ignore", invalid="ignore"):
        return LawComparison(LAWS, np.sqrt(np.mean(stacked**2, axis=2)))
