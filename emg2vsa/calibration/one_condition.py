"""One angle and condition of the rig: its scores, their law, and the new specimen by it."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from casr.doubts import Stretch, unlike_others
from emg2vsa.arrays import Floats, Ints
from emg2vsa.calibration.calibrate import calibrate
from emg2vsa.calibration.forms import (
    INDENTATION_POWER,
    casr_angle_share,
    casr_exponent,
    growth_power,
    indentation_exponent,
    mount_share,
    specimen_share,
)
from emg2vsa.calibration.fusion import Fusion, calibrate_indentation, fuse, mm_per_n
from emg2vsa.calibration.left_out import compare_laws
from emg2vsa.calibration.mountings import MountingScatter, mounting_scatter, pooled
from emg2vsa.calibration.presses import MOST_OUTLIERS, far_off, without_outliers
from emg2vsa.calibration.repeats import RepeatInterval, labels_side_by_side, side_by_side
from emg2vsa.calibration.results import AlgorithmResult, ConditionResult, DesignByPins, FusedResult, LawResult, OnLaw
from emg2vsa.calibration.unknown import Estimate, estimate
from emg2vsa.run_scores import ALGORITHMS, RunScores
from emg2vsa.settings import PAPER, CalibrationSettings, Law

_MOST_UNLIKE = 0.5
"Share of a specimen's presses whose skin stretched otherwise, beyond which the specimen is named."


@dataclasses.dataclass(frozen=True, eq=False)
class Scores:
    """K scores of every press of one condition, by several vision algorithms or for several choices of presses: of the
    known specimens (K, S, R) and the new one (K, R), and the mounting of each press.
    """

    known: Floats
    new: Floats
    labels: Ints
    new_labels: Ints


Way = Literal["chosen", "paper", "indentation"]
"""By the settings of the study, by those of the paper, or by how deep the probe goes in."""
WAYS: tuple[Way, ...] = get_args(Way)


@dataclasses.dataclass(frozen=True, eq=False)
class OneCondition:
    known: tuple[RunScores, ...]
    new: RunScores
    kappa: Floats
    kappa_se: Floats
    truth: float
    settings: CalibrationSettings

    def scores(self, way: Way) -> Scores:
        """Scores of all presses by every vision algorithm, without outliers where the settings leave them out; or those
        of the indentation."""
        if way == "indentation":
            return self._side_by_side([mm_per_n(run.indent_n_per_mm)[None] for run in self._runs])
        mads = self._settings(way).outlier_mads
        return self._side_by_side(
            [without_outliers(np.stack([run.casr[name] for name in ALGORITHMS]), mads) for run in self._runs]
        )

    def many_scores(self, name: str, which: Mapping[int, NDArray[np.bool_]]) -> Scores:
        """Scores by one vision algorithm for K choices of presses. which : of each run, by ``id``, (K, R)."""
        casr = (np.where(which[id(run)], run.casr[name], np.nan) for run in self._runs)
        return self._side_by_side([without_outliers(each, self.settings.outlier_mads) for each in casr])

    def _side_by_side(self, scores: Sequence[Floats]) -> Scores:
        *known, new = scores
        whole = np.stack([_padded(of) for of in zip(*known, strict=True)])
        return Scores(whole, new, self._labels, self.new.mounting)

    @property
    def _runs(self) -> tuple[RunScores, ...]:
        return (*self.known, self.new)

    def _settings(self, way: Way) -> CalibrationSettings:
        return dataclasses.replace(self.settings, **PAPER["calibration"]) if way == "paper" else self.settings

    def result(self, scatter: Mapping[Way, MountingScatter], by_pins: DesignByPins) -> ConditionResult:
        depth, pins = self._indentation(scatter["indentation"]), by_pins.pins
        return ConditionResult(
            angle_deg=self.new.angle_deg,
            condition=self.new.condition,
            simulated=any(run.simulated for run in (*self.known, self.new)),
            specimens=self._names,
            known_kappa=self.kappa,
            exponent=1 / self._growth,
            algorithms=self._algorithms(depth, scatter),
            indentation=None if depth is None else law_result(depth, self.truth),
            pins=pins and dataclasses.replace(pins, error=pins.kappa / self.truth - 1),
            no_pins=by_pins.no_pins,
        )

    def _algorithms(self, depth: Estimate | None, scatter: Mapping[Way, MountingScatter]) -> dict[str, AlgorithmResult]:
        """By vision algorithm; all of them at once, as their arrays are small."""
        kept = self.scores("chosen")
        chosen = self.estimated(ALGORITHMS, kept, self.settings, scatter["chosen"])
        of_paper = self.estimated(ALGORITHMS, self.scores("paper"), self._settings("paper"), scatter["paper"])
        fused = None if depth is None else self._both(chosen, kept.new, depth)
        laws = compare_laws(self.kappa, kept.known, self.settings, casr_unit=self._casr_unit)
        by = {}
        for i, name in enumerate(ALGORITHMS):
            casr, new_casr = _padded([run.casr[name] for run in self.known]), self.new.casr[name]
            notes = (*self._left_out_presses(casr, new_casr), *self._other_friction)
            by[name] = AlgorithmResult(
                casr=casr,
                new_casr=new_casr,
                casr_unit=self._casr_unit,
                chosen=law_result(chosen, self.truth, i, notes),
                paper=law_result(of_paper, self.truth, i),
                left_out_rms={law: float(score[i]) for law, score in zip(laws.laws, laws.score, strict=True)},
                best_law=laws.best(i) or "",
                fused=None if fused is None else self._fused(fused, i),
            )
        return by

    def _kept(self, scores: Floats) -> Floats:
        return without_outliers(scores, self.settings.outlier_mads)

    def _left_out_presses(self, casr: Floats, new_casr: Floats) -> tuple[str, ...]:
        names = (*self._names, self.new.specimen)
        lost = [np.count_nonzero(np.isfinite(row) & np.isnan(self._kept(row[None])[0])) for row in (*casr, new_casr)]
        said = ", ".join(f"{count} of {name}" for count, name in zip(lost, names, strict=True) if count)
        limit = f"{self.settings.outlier_mads:g} median absolute deviations"
        kept = ", ".join(
            f"{far} of {name}"
            for row, name in zip((*casr, new_casr), names, strict=True)
            if (far := int(np.count_nonzero(far_off(row[None], self.settings.outlier_mads)))) > self._most_outliers(row)
        )
        notes = (f"presses left out, more than {limit} from their specimen's median: {said}",) if said else ()
        many = f"presses kept although more than {limit} off, as more than {MOST_OUTLIERS:.0%} of a specimen: {kept}"
        return (*notes, many) if kept else notes

    @staticmethod
    def _most_outliers(presses: Floats) -> float:
        return MOST_OUTLIERS * np.count_nonzero(np.isfinite(presses))

    def estimated(
        self,
        algorithms: Sequence[str],
        scores: Scores,
        settings: CalibrationSettings,
        scatter: MountingScatter,
        *,
        bootstrap: bool = True,
    ) -> Estimate:
        """The new specimen by K spread rates; algorithms : (K,) the vision algorithm of each."""
        angles = [casr_angle_share(name, self.new.angle_deg, settings.angle_sd_deg) for name in algorithms]
        calibration = calibrate(
            self.kappa,
            scores.known,
            settings,
            casr_unit=self._casr_unit,
            specimens=self._names,
            kappa_se=self.kappa_se,
            specimen_share=[specimen_share(name) for name in algorithms],
            angle_share=angles,
            mountings=self._labels,
            scatter=scatter,
            other_exponent=casr_exponent(self._growth),
        )
        return estimate(calibration, scores.new, self.new.mounting, known=self.truth, bootstrap=bootstrap)

    def _indentation(self, scatter: MountingScatter) -> Estimate | None:
        slopes = _padded([run.indent_n_per_mm for run in self.known])
        if not (np.any(np.isfinite(slopes), axis=1).all() and np.any(np.isfinite(self.new.indent_n_per_mm))):
            return None
        calibration = calibrate_indentation(
            self.kappa,
            slopes,
            self.settings,
            specimens=self._names,
            kappa_se=self.kappa_se,
            angle_share=mount_share(INDENTATION_POWER, self.new.angle_deg, self.settings.angle_sd_deg),
            mountings=self._labels,
            scatter=scatter,
            other_exponent=indentation_exponent(self._growth),
        )
        return estimate(calibration, mm_per_n(self.new.indent_n_per_mm), self.new.mounting, known=self.truth)

    def _both(self, cutaneous: Estimate, scores: Floats, kinesthetic: Estimate) -> Fusion:
        depth = mm_per_n(self.new.indent_n_per_mm)[None]
        c, k = cutaneous.repeats, kinesthetic.repeats
        return fuse(cutaneous.calibration, c, scores, kinesthetic.calibration, k, depth, self.new.mounting)

    def _fused(self, fusion: Fusion, i: int) -> FusedResult:
        return FusedResult(
            kappa=float(fusion.kappa[i]),
            low=float(fusion.low[i]),
            high=float(fusion.high[i]),
            error=float(fusion.kappa[i] / self.truth - 1),
            weight=float(fusion.weight[i]),
            correlation=float(fusion.correlation[i]),
            chi2=float(fusion.chi2[i]),
            p=float(fusion.p[i]),
            notes=fusion.notes(i),
        )

    @cached_property
    def _labels(self) -> Ints:
        return padded_labels(self.known, max(len(run.mounting) for run in self.known))

    @cached_property
    def _other_friction(self) -> tuple[str, ...]:
        """The law takes all specimens for alike in friction: one whose skin stretches otherwise is said."""
        runs = (*self.known, self.new)
        stretches = {
            (run.specimen, number): Stretch(curve.stretch_force_n, curve.stretch_log_ratio, curve.stretch_log_sd)
            for run in runs
            for number, curve in zip(run.repetitions.tolist(), run.curves, strict=True)
            if curve.stretch_force_n.size
        }
        unlike = unlike_others({f"{name} {number}": stretch for (name, number), stretch in stretches.items()})
        notes = []
        for run in runs:
            own = [f"{name} {number}" for name, number in stretches if name == run.specimen]
            apart = [unlike[press] for press in own if press in unlike]
            if len(apart) > _MOST_UNLIKE * len(own):
                notes.append(f"{run.specimen} may have other friction, {len(apart)} of {len(own)} presses: {apart[0]}")
        return tuple(notes)

    @cached_property
    def _growth(self) -> float:
        return growth_power((*self.known, self.new))

    @property
    def _names(self) -> tuple[str, ...]:
        return tuple(run.specimen for run in self.known)

    @property
    def _casr_unit(self) -> str:
        return f"{self.new.area_unit}/N"


def law_result(found: Estimate, truth: float, i: int = 0, notes: tuple[str, ...] = ()) -> LawResult:
    """Estimate ``i`` as plain numbers. truth : known kappa of the new specimen, N/mm, NaN where it is not known."""
    calibration, serial, without = found.calibration, found.repeats.serial, found.left_out
    law, known = calibration.settings.law, calibration.kappa[i]
    first, second = calibration.fit.parameters[i].tolist()
    told = [(law, found.repeats), *((each.law, each.repeats) for each in found.rivals if each.counts[i])]
    return LawResult(
        law=law,
        minimise=calibration.settings.minimise,
        equation=calibration.equation(i),
        parameters=(first, second),
        r2=float(calibration.r2[i]),
        adj_r2=float(calibration.adj_r2[i]),
        kappa=float(found.kappa[i]),
        low=float(found.low[i]),
        high=float(found.high[i]),
        bootstrap_low=float(found.bootstrap_low[i]),
        bootstrap_high=float(found.bootstrap_high[i]),
        error=float(found.kappa[i] / truth - 1),
        left_out=without.kappa[i],
        law_p=float(without.law_p[i]),
        notes=(*notes, *found.notes(i)),
        determined=bool(found.determined[i]),
        widened=float(found.repeats.widened[i]),
        serial_correlation=float(serial.rho[i]),
        serial_p=float(serial.p[i]),
        effective_presses=float(serial.effective_n[i, -1]),
        amplification=abs(float(found.repeats.score_share[i])),
        mounting_sd=float(calibration.mounting.sd[i]),
        mounting_freedom=float(calibration.mounting.freedom[i]),
        on_laws=tuple(_on_law(by, repeats, i, truth) for by, repeats in told),
        fitted_on_law=tuple(_on_law(law, *each) for each in zip(found.fitted, [i] * len(known), known, strict=True)),
    )


def _on_law(law: Law, found: RepeatInterval, i: int, known: float) -> OnLaw:
    return OnLaw(law, float(found.eta[i]), float(found.eta_se[i]), float(found.df[i]), float(known))


def _padded(rows: Sequence[Floats]) -> Floats:
    """(S, R), padded with NaN to as many presses as the longest has."""
    longest = max(row.size for row in rows)
    return np.stack([np.pad(row.astype(np.float64), (0, longest - row.size), constant_values=np.nan) for row in rows])


def pooled_scatter(designs: Sequence[Scores], settings: CalibrationSettings) -> list[MountingScatter]:
    """How the mountings of each condition differ, as those of all conditions show."""
    if not designs:
        return []
    each = [
        mounting_scatter(
            side_by_side(of.known, of.new),
            labels_side_by_side(of.labels, of.new.shape[1], of.new_labels),
            settings.mounting_sd_percent / 100,
        )
        for of in designs
    ]
    names = [field.name for field in dataclasses.fields(MountingScatter)]
    whole = {name: np.stack([getattr(one, name) for one in each]) for name in names}
    choices = [
        pooled(MountingScatter(**{name: values[:, k] for name, values in whole.items()}))
        for k in range(len(designs[0].new))
    ]
    together = {name: np.stack([getattr(one, name) for one in choices], axis=1) for name in names}
    return [MountingScatter(**{name: values[i] for name, values in together.items()}) for i in range(len(designs))]


def padded_labels(runs: Sequence[RunScores], presses: int) -> Ints:
    """(S, R) mounting of each press, 0 where there is none."""
    return np.stack([np.pad(run.mounting, (0, presses - len(run.mounting))) for run in runs])
