"""The calibration stage: from scored runs to the stiffness of a new specimen, for every angle and condition."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats
from emg2vsa.calibration.by_pins import LEAST_SPECIMENS
from emg2vsa.calibration.cut_presses import cut_all, cut_forces
from emg2vsa.calibration.forms import growth_power
from emg2vsa.calibration.one_condition import WAYS, OneCondition, law_result, padded_labels, pooled_scatter
from emg2vsa.calibration.online import OnlineCalibration
from emg2vsa.calibration.online_pins import known_pins
from emg2vsa.calibration.results import CalibrationResults, DesignByPins, Headline, LawResult
from emg2vsa.errors import DataError
from emg2vsa.run_scores import RunScores
from emg2vsa.run_scores.domes import NO_DOMES, Domes
from emg2vsa.settings import CalibrationSettings

_NO_NEW_SPECIMEN = "No stiffness was estimated: the study names no new_specimen under [profile]."


def calibrate_runs(
    runs: Sequence[RunScores],
    kappa: Mapping[str, float],
    new_specimen: str,
    settings: CalibrationSettings | None = None,
    *,
    kappa_se: Mapping[str, float] | None = None,
    by_pins: Sequence[DesignByPins] = (),
) -> CalibrationResults:
    """Calibrate every angle and condition at which the new specimen was pressed.

    kappa : specimen to its stiffness by plate indentation, N/mm; that of the new specimen, if there, is the truth that
    its estimate is held against and enters no fit. kappa_se : its standard error, 0 where not given. Specimens without
    a stiffness are left out. by_pins : what the pins tell, of each angle and condition where they were asked.
    Where the study names no new specimen there is nothing to calibrate, and a note says so.
    DataError where no run is of the one it names.
    """
    settings = settings or CalibrationSettings()
    if not new_specimen:
        return CalibrationResults("", float("nan"), (), (_NO_NEW_SPECIMEN,))
    new_runs = [run for run in runs if run.specimen == new_specimen]
    if not new_runs:
        raise DataError(
            "calibration",
            wanted=f"a run of the new specimen, {new_specimen}",
            found=", ".join(sorted({run.specimen for run in runs})) or "no runs",
            do="Press it, or name another new specimen.",
        )
    conditions, notes = _conditions(runs, kappa, new_runs, settings, kappa_se or {})
    scatters = {way: pooled_scatter([each.scores(way) for each in conditions], settings) for way in WAYS}
    pins = {(each.angle_deg, each.condition): each for each in by_pins}
    results = []
    for i, each in enumerate(conditions):
        place = each.new.angle_deg, each.new.condition
        told = pins.get(place) or DesignByPins(*place, None, "its pins were not asked")
        results.append(each.result({way: of[i] for way, of in scatters.items()}, told))
    return CalibrationResults(new_specimen, kappa.get(new_specimen, float("nan")), tuple(results), tuple(notes))


def _conditions(
    runs: Sequence[RunScores],
    kappa: Mapping[str, float],
    new_runs: Sequence[RunScores],
    settings: CalibrationSettings,
    kappa_se: Mapping[str, float],
) -> tuple[list[OneCondition], list[str]]:
    """Every angle and condition of the new specimen's runs, and which of them cannot be calibrated."""
    conditions, notes = [], []
    for new in new_runs:
        known = [run for run in runs if _same_place(run, new) and run.specimen in kappa and run is not new]
        if len(known) < LEAST_SPECIMENS:
            notes.append(f"{new.angle_deg:g}°, {new.condition}: {len(known)} known specimens, too few to calibrate")
            continue
        stiffness = np.array([kappa[run.specimen] for run in known])
        error = np.array([kappa_se.get(run.specimen, 0.0) for run in known])
        truth = kappa.get(new.specimen, float("nan"))
        conditions.append(OneCondition(tuple(known), new, stiffness, error, truth, settings))
    return conditions, notes


@dataclasses.dataclass(frozen=True)
class ChosenLaws:
    """The law that the settings choose, by condition, angle and vision algorithm; whatever presses are chosen for it,
    where the pins tell kappa of ``study`` their estimate stays."""

    study: CalibrationResults
    by: dict[tuple[str, float, str], LawResult] = dataclasses.field(default_factory=dict)

    def law(self, condition: str, angle_deg: float, algorithm: str) -> LawResult | None:
        """The chosen law at an angle in degrees; None where it was not calibrated."""
        return self.by.get((condition, angle_deg, algorithm))

    def headline(self, condition: str, angle_deg: float, algorithm: str) -> Headline | None:
        """Kappa by the pins, or else by this law. angle_deg : degrees."""
        design = self.study.find(angle_deg, condition)
        return (design.pins if design else None) or self.law(condition, angle_deg, algorithm)


def chosen_laws(
    runs: Sequence[RunScores],
    kept: Sequence[NDArray[np.bool_]],
    algorithms: Sequence[str],
    kappa: Mapping[str, float],
    new_specimen: str,
    settings: CalibrationSettings,
    kappa_se: Mapping[str, float],
    study: CalibrationResults,
) -> list[ChosenLaws]:
    """The laws of ``calibrate_runs`` for K choices of presses at once, without bootstrap and without companions.

    kept : of each run (K, R), which presses count. How contacts grow with force is taken from all presses.
    """
    which = {id(run): own for run, own in zip(runs, kept, strict=True)}
    new_runs = [run for run in runs if run.specimen == new_specimen]
    conditions, _ = _conditions(runs, kappa, new_runs, settings, kappa_se)
    found = [ChosenLaws(study) for _ in range(len(kept[0]) if kept else 0)]
    for name in algorithms if conditions and found else ():
        scores = [each.many_scores(name, which) for each in conditions]
        for each, own, scatter in zip(conditions, scores, pooled_scatter(scores, settings), strict=True):
            by = each.estimated([name] * len(found), own, settings, scatter, bootstrap=False)
            for k, laws in enumerate(found):
                laws.by[each.new.condition, each.new.angle_deg, name] = law_result(by, each.truth, k)
    return found


def online_calibrations(
    runs: Sequence[RunScores],
    kappa: Mapping[str, float],
    new_specimen: str,
    force_n: tuple[float, float],
    settings: CalibrationSettings | None = None,
    *,
    kappa_se: Mapping[str, float] | None = None,
    domes: Mapping[str, Domes] | None = None,
    provenance: Mapping[str, str] | None = None,
    found: CalibrationResults | None = None,
) -> tuple[OnlineCalibration, ...]:
    """A calibration for presses of unknown specimens, for every angle and condition that has the presses for it.

    Arguments as for ``calibrate_runs``; the new specimen is left out. force_n : loading phase that was scored.
    domes : specimen to the tables that its pins are held against, those of casr where not given.
    found : of the same runs by ``calibrate_runs``, whose fits to the pins are taken; None fits them.
    """
    settings = settings or CalibrationSettings()
    forces = cut_forces(*force_n)
    usable = [run for run in runs if run.specimen in kappa and run.specimen != new_specimen]
    made = []
    for angle_deg, condition in dict.fromkeys((run.angle_deg, run.condition) for run in usable):
        known = [run for run in usable if (run.angle_deg, run.condition) == (angle_deg, condition)]
        rates = cut_all([_areas(run) for run in known], force_n[0], forces)
        there = np.flatnonzero(np.isfinite(rates[:, :, -1]).any(axis=1))
        if there.size < LEAST_SPECIMENS:
            continue
        known = [known[s] for s in there]
        stiffness = np.array([kappa[run.specimen] for run in known])
        errors = np.array([(kappa_se or {}).get(run.specimen, 0.0) for run in known])
        specimens = tuple(run.specimen for run in known)
        fitted = found.find(angle_deg, condition) if found else None
        pins = (
            fitted.pins.known
            if fitted and fitted.pins and fitted.specimens == specimens
            else known_pins(known, stiffness, errors, [(domes or {}).get(name, NO_DOMES) for name in specimens])
        )
        own = OnlineCalibration(
            specimens=specimens, kappa=stiffness, kappa_se=errors, quantity=known[0].algorithm,
            area_unit=known[0].area_unit, angle_deg=float(angle_deg), condition=condition, start_n=force_n[0],
            forces_n=forces, rates=rates[there], mounting=padded_labels(known, rates.shape[1]), settings=settings,
            growth=growth_power(known), simulated=any(run.simulated for run in known),
            provenance=dict(provenance or {}), pins=pins,
        )  # fmt: skip
        made.append(own)
    return tuple(made)


def _areas(run: RunScores) -> list[tuple[Floats, Floats]]:
    return [(curve.force_n, curve.area_mm2) for curve in run.curves]


def _same_place(run: RunScores, new: RunScores) -> bool:
    return (run.angle_deg, run.condition) == (new.angle_deg, new.condition) and run.specimen != new.specimen
