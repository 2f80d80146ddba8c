"""The stiffness of the new specimen by the whole field of the pins: the presses of one angle and condition."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from casr.kappa.discrepancy import Discrepancy
from casr.kappa.estimate import estimate_kappa
from casr.kappa.known import KnownSensor
from emg2vsa.arrays import Floats
from emg2vsa.calibration.online_pins import KnownPins
from emg2vsa.calibration.pinned_presses import camera_of, known_presses, library_of, presses_of
from emg2vsa.calibration.results import PinsResult
from emg2vsa.run_scores import RunScores
from emg2vsa.run_scores.domes import Domes
from emg2vsa.settings import CalibrationSettings


def kappa_by_pins(
    known: Sequence[RunScores],
    new: RunScores,
    kappa: Floats,
    kappa_se: Floats,
    truth: float,
    domes: Sequence[Domes],
    settings: CalibrationSettings,
) -> PinsResult:
    """Kappa of the new specimen by its presses and those of S known specimens.

    kappa, kappa_se : (S,) N/mm. truth : known kappa of the new specimen, NaN where it is not known; it enters no fit.
    domes : whose tables, and how high each specimen is, S and the new one. settings : confidence, and how far mountings
    scatter.
    DataError, casr.errors.CasrError : the pins tell none.
    """
    camera = camera_of((*known, new))
    library = library_of(camera, domes)
    of_known = known_presses(known, kappa, kappa_se)
    found = estimate_kappa(
        [*of_known, *presses_of(new, None, 0.0)], camera, library=library,
        discrepancy=Discrepancy().mounted(settings.mounting_sd_percent / 100), confidence=settings.confidence,
    )  # fmt: skip
    own, rest = found.kappas[new.specimen], [found.kappas.get(run.specimen) for run in known]
    left_out = np.array([(each.value, each.low, each.high) if each else (np.nan,) * 3 for each in rest])
    return PinsResult(
        kappa=own.value, low=own.low, high=own.high, error=own.value / truth - 1, determined=own.determined,
        expected=own.expected, bound_sd=own.bound_sd, efficiency=own.efficiency, by_cue=own.by_cue,
        misfit=found.misfit, presses=own.n_presses, left_out=left_out[:, 0], left_out_low=left_out[:, 1],
        left_out_high=left_out[:, 2], log_sd=own.log_sd, freedom=own.freedom, kappa0=own.kappa0, notes=found.notes,
        known=KnownPins(KnownSensor.of(found.labels.among(range(len(of_known)))), camera, found.labels.family.digest),
    )  # fmt: skip
