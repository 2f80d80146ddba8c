"""The stiffness of the new specimen by the whole field of the pins: the presses of one angle and condition."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from casr.errors import CasrError
from casr.kappa.discrepancy import Discrepancy
from casr.kappa.estimate import estimate_kappa
from casr.kappa.known import KnownSensor
from emg2vsa.arrays import Floats
from emg2vsa.calibration.online_pins import KnownPins
from emg2vsa.calibration.pinned_presses import camera_of, known_presses, library_of, presses_of
from emg2vsa.calibration.results import DesignByPins, PinsResult
from emg2vsa.errors import DataError
from emg2vsa.run_scores import RunScores
from emg2vsa.run_scores.domes import NO_DOMES, Domes

LEAST_SPECIMENS = 2
"Known ones that a calibration takes."


def design_by_pins(
    runs: Sequence[RunScores],
    kappa: Mapping[str, float],
    new_specimen: str,
    *,
    kappa_se: Mapping[str, float],
    domes: Mapping[str, Domes],
    confidence: float,
    mounting_sd_percent: float,
) -> DesignByPins:
    """Kappa of the new specimen by the pins of the runs at one angle under one condition.

    kappa, kappa_se : specimen to its stiffness and standard error, N/mm; that of the new one is not looked at.
    Specimens without a stiffness, or without a press whose pins could be followed, are left out. domes : specimen to
    the tables that its pins are held against, those of casr where not given. mounting_sd_percent : scatter of kappa
    from one mounting to the next. PassingError : the tables that come with casr are damaged.
    """
    design = runs[0].angle_deg, runs[0].condition
    new = next((run for run in runs if run.specimen == new_specimen), None)
    known = [run for run in runs if run.specimen in kappa and run.specimen != new_specimen]
    unseen = [run for run in known if not any(run.pins)]
    if new is None or len(known) - len(unseen) < LEAST_SPECIMENS:
        wanted = "the new specimen and two known ones with scores, and with pins that can be followed"
        return DesignByPins(*design, None, f"expected {wanted}, but found fewer")
    stated = np.array([kappa[run.specimen] for run in known])
    errors = np.array([kappa_se.get(run.specimen, 0.0) for run in known])
    of_runs = [domes.get(run.specimen, NO_DOMES) for run in (*known, new)]
    try:
        found = _kappa_by_pins(known, new, stated, errors, of_runs, confidence, mounting_sd_percent)
    except (CasrError, DataError) as error:  # no PassingError, which says nothing of the presses
        return DesignByPins(*design, None, str(error))
    left = tuple(f"{run.name} is left out: none of its presses has pins that can be followed" for run in unseen)
    return DesignByPins(*design, replace(found, notes=(*left, *found.notes)))


def _kappa_by_pins(
    known: Sequence[RunScores],
    new: RunScores,
    kappa: Floats,
    kappa_se: Floats,
    domes: Sequence[Domes],
    confidence: float,
    mounting_sd_percent: float,
) -> PinsResult:
    """kappa, kappa_se : (S,) of the known specimens. domes : of them and the new one. InputError : the pins tell
    none."""
    camera = camera_of([*(run for run in known if any(run.pins)), new])
    library = library_of(camera, domes)
    of_known = known_presses(known, kappa, kappa_se)
    found = estimate_kappa(
        [*of_known, *presses_of(new, None, 0.0)], camera, library=library,
        discrepancy=Discrepancy().mounted(mounting_sd_percent / 100), confidence=confidence,
    )  # fmt: skip
    own, rest = found.kappas[new.specimen], [found.kappas.get(run.specimen) for run in known]
    left_out = np.array([(each.value, each.low, each.high) if each else (np.nan,) * 3 for each in rest])
    return PinsResult(
        kappa=own.value, low=own.low, high=own.high, error=np.nan, determined=own.determined,
        expected=own.expected, bound_sd=own.bound_sd, efficiency=own.efficiency, by_cue=own.by_cue,
        misfit=found.misfit, presses=own.n_presses, left_out=left_out[:, 0], left_out_low=left_out[:, 1],
        left_out_high=left_out[:, 2], log_sd=own.log_sd, freedom=own.freedom, kappa0=own.kappa0, notes=found.notes,
        known=KnownPins(KnownSensor.of(found.labels.among(range(len(of_known)))), camera, found.labels.family.digest),
    )  # fmt: skip
