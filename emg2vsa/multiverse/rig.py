"""Paths of analysis of the rig's presses: from their scores to the claims."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from casr.doubts import Stretch, unlike_others
from casr.errors import CasrError
from casr.spread import spread_rate
from emg2vsa.arrays import Floats, Ints
from emg2vsa.calibration.laws import WAYS
from emg2vsa.calibration.presses import far_off
from emg2vsa.calibration.results import CalibrationResults
from emg2vsa.calibration.runs_calibration import ChosenLaws, chosen_laws
from emg2vsa.claims.claim import Claim
from emg2vsa.claims.kappa import DESIGNS as KAPPA_DESIGNS
from emg2vsa.claims.kappa import NEW, OLD, STEPS
from emg2vsa.claims.on_rig import claims_on_rig
from emg2vsa.discrimination.run_table import RunTable, run_table
from emg2vsa.errors import DataError
from emg2vsa.multiverse.path import (
    ALGORITHM,
    EXCLUSIONS,
    KAPPA,
    MOUNTING,
    MOUNTING_SD,
    PRESS,
    RATE,
    SPECIMEN,
    Choice,
    Tried,
    tried,
)  # fmt: skip
from emg2vsa.run_scores import ALGORITHMS, PressCurve, RunScores
from emg2vsa.settings import CalibrationSettings
from emg2vsa.study import Study

Points = Literal["means", "repetitions"]
Presses = NDArray[np.bool_]
"""(D, S, R) presses that count, as in ``RunTable``."""
Cell = tuple[str, float, str]
"""Condition, angle and specimen."""
FAR_MADS = 5.0
"""A score lies far from the median of its run."""
SD_FACTORS = (0.5, 1.5)
LAW_PARAMETERS = 2
"""Parameters of a law of kappa. It passes through as many specimens, whatever they are."""
_OF_THEIR_OWN = tuple(f"reduction_{key}" for key, step in STEPS.items() if step.before[1] and step.after[1])
"""Claims that name their algorithms."""
_FITTED = tuple(f"kappa_fit_{key}" for key in KAPPA_DESIGNS)
_RATES = {"power": "slope", "slope": "power"}


def rig_paths(
    study: Study, runs: Sequence[RunScores], table: RunTable | None, calibration: CalibrationResults | None
) -> Iterator[Tried]:
    """The study's own path first; then vision algorithms, laws of kappa and exclusions crossed, and the other choices
    one at a time."""
    own = _Rig(study, tuple(runs), table, calibration)
    rules = [(None, own.everything), *own.exclusions()]
    for way, settings in _ways(study.calibration) if calibration else [(None, study.calibration)]:
        by_way = own.calibrated_by(settings)
        laws = by_way.laws([presses for _, presses in rules], ALGORITHMS)
        for algorithm in dict.fromkeys((own.algorithm, *ALGORITHMS)):
            other = Choice(ALGORITHM, algorithm) if algorithm != own.algorithm else None
            for (rule, presses), by in zip(rules, laws, strict=True):
                found = by_way.claims(presses, by, algorithm, of_scores=way is None)
                yield tried((way, other, rule), found, _OF_THEIR_OWN if other else ())
    left = list(own.left_out())
    for (choice, presses, cell), by in zip(left, own.laws([presses for _, presses, _ in left]), strict=True):
        claims = list(own.claims(presses, by))
        yield tried([choice], claims, [claim.key for claim in claims if not _compares(claim, cell)])
    for choice, changed in own.changes():
        these = rules if choice.kind == RATE else [(None, changed.everything)]
        for (rule, presses), by in zip(these, changed.laws([presses for _, presses in these]), strict=True):
            claims = list(changed.claims(presses, by))
            gone = set(own.known) - set(changed.known)
            not_on = [claim.key for claim in claims if gone and claim.specimens and not gone & set(claim.specimens)]
            not_on += () if len(changed.known) > LAW_PARAMETERS else _FITTED
            yield tried([choice, rule], claims, not_on)


def _compares(claim: Claim, cell: Cell) -> bool:
    """Whether the presses of a cell are among those of the claim; drift joins the others to them, but faintly."""
    return cell[:2] in claim.designs and cell[2] in (claim.specimens or (cell[2],))


@dataclass(frozen=True)
class _Rig:
    """Data that the claims of a study on its rig come from."""

    study: Study
    runs: tuple[RunScores, ...]
    table: RunTable | None
    calibration: CalibrationResults | None

    @property
    def algorithm(self) -> str:
        return self.study.scoring.algorithm

    @cached_property
    def _sorted(self) -> RunTable:
        study = self.study
        return self.table or run_table(self.runs, study.pressed_n_per_mm, study.profile.new_specimen or "")

    @property
    def known(self) -> list[str]:
        """Specimens other than the new one."""
        return [self._sorted.specimens[s] for s in self._sorted.known]

    @cached_property
    def everything(self) -> Presses:
        return np.ones(self._sorted.mounting.shape, dtype=np.bool_)

    def calibrated_by(self, settings: CalibrationSettings) -> _Rig:
        """The same with other settings of calibration."""
        return replace(self, study=replace(self.study, calibration=settings))

    def _place(self, run: RunScores) -> tuple[int, int]:
        return self._sorted.design(run.condition, run.angle_deg), self._sorted.specimens.index(run.specimen)

    def laws(self, presses: Sequence[Presses], algorithms: Sequence[str] = ()) -> list[ChosenLaws] | list[None]:
        """For each choice of presses; None where the study has no kappa. algorithms : those of the claims, if none."""
        if self.calibration is None:
            return [None] * len(presses)
        study, names = self.study, algorithms or tuple(dict.fromkeys((self.algorithm, OLD, NEW)))
        kept = [np.array([own[self._place(run)][: run.repetitions.size] for own in presses]) for run in self.runs]
        kappa, errors = study.kappa_of_scores
        new = study.profile.new_specimen or ""
        return chosen_laws(self.runs, kept, names, kappa, new, study.calibration, errors, self.calibration)

    def claims(
        self, presses: Presses, laws: ChosenLaws | None, algorithm: str = "", *, of_scores: bool = True
    ) -> Iterator[Claim]:
        """Claims by the ``presses`` and the ``laws`` through them, by a vision algorithm, that of the study if none.

        of_scores : False for claims on kappa alone.
        """
        name = algorithm or self.algorithm
        study = replace(self.study, scoring=replace(self.study.scoring, algorithm=name))  # type: ignore[arg-type]
        table = self.table if of_scores else None
        if table is not None:
            casr, area = (_of_presses(scores, name, presses) for scores in (table.casr, table.start_area))
            table = replace(table, algorithm=name, casr=casr, start_area=area)
        yield from claims_on_rig(study, table, laws)

    def left_out(self) -> Iterator[tuple[Choice, Presses, Cell]]:
        """Without each mounting of a cell with several, and without each press; and the cell that it was of."""
        table = self._sorted
        there = table.mounting > 0
        for d, s in np.ndindex(there.shape[:2]):
            cell = table.conditions[d], float(table.angles_deg[d]), table.specimens[s]
            where = f"{cell[2]} {cell[0]} {cell[1]:g}°"
            numbers, (own,) = np.unique(table.mounting[d, s][there[d, s]]), np.nonzero(there[d, s])
            less = [(MOUNTING, f"mounting {n}", table.mounting[d, s] == n) for n in numbers if numbers.size > 1]
            less += [(PRESS, f"press {r + 1}", np.arange(there.shape[2]) == r) for r in own if own.size > 1]
            for kind, what, left in less:
                presses = there.copy()
                presses[d, s] &= ~left
                yield Choice(kind, f"without {what} of {where}"), presses, cell

    def exclusions(self) -> Iterator[tuple[Choice, Presses]]:
        """By rules: without doubtful presses, scores far off, and the first or the last press of every mounting."""
        doubtful = set(_doubtful(self.runs))
        rules: dict[str, Callable[[RunScores], Presses]] = {
            "without presses whose skin stretched otherwise": lambda run: np.array(
                [(run.name, r) in doubtful for r in range(run.repetitions.size)]
            ),
            "without outlying scores": lambda run: far_off(run.casr[self.algorithm][None], FAR_MADS)[0],
        }
        if any(np.unique(run.mounting).size < run.mounting.size for run in self.runs):
            rules["without the first press of every mounting"] = lambda run: _first_of_each(run.mounting)
            rules["without the last press of every mounting"] = lambda run: _first_of_each(run.mounting[::-1])[::-1]
        for says, rule in rules.items():
            presses = self.everything.copy()
            for run in self.runs:
                presses[self._place(run)][: run.repetitions.size] &= ~rule(run)
            if not presses.all():
                yield Choice(EXCLUSIONS, says), presses

    def changes(self) -> Iterator[tuple[Choice, _Rig]]:
        """Another rate rule, other settings of calibration, and each known specimen left out."""
        if (rates := _other_rates(self.study, self.runs)) is not None:
            rule, runs = rates
            with suppress(DataError):
                yield Choice(RATE, rule), self._of(runs)
        own = self.study.calibration
        for factor in SD_FACTORS if own.mounting_sd_percent else ():
            sd = own.mounting_sd_percent * factor
            settings = replace(own, mounting_sd_percent=sd)
            yield Choice(MOUNTING_SD, f"assumed SD of mountings {sd:g} %"), self.calibrated_by(settings)
        for specimen in self.known if len(self.known) > LAW_PARAMETERS else ():
            left = tuple(run for run in self.runs if run.specimen != specimen)
            yield Choice(SPECIMEN, f"without {specimen}"), self._of(left)

    def _of(self, runs: tuple[RunScores, ...]) -> _Rig:
        other = _Rig(self.study, runs, None, self.calibration)
        return other if self.table is None else replace(other, table=other._sorted)


def _first_of_each(numbers: Ints) -> Presses:
    """(n,) whether a value is there for the first time."""
    found = np.zeros(numbers.size, dtype=np.bool_)
    found[np.unique(numbers, return_index=True)[1]] = True
    return found


def _of_presses(scores: dict[str, Floats], algorithm: str, presses: Presses) -> dict[str, Floats]:
    return {name: np.where(presses, own, np.nan) for name, own in scores.items() if name == algorithm}


def _ways(own: CalibrationSettings) -> Iterator[tuple[Choice | None, CalibrationSettings]]:
    """The study's own law of kappa, through other points, and every other law by every error that it can make least."""
    yield None, own
    points: Points = "repetitions" if own.points == "means" else "means"
    yield Choice(KAPPA, f"law through {points}"), replace(own, points=points)
    for law, errors in WAYS.items():
        for minimise in errors:
            if (law, minimise) != (own.law, own.minimise):
                yield Choice(KAPPA, f"{law} law, errors of {minimise}"), replace(own, law=law, minimise=minimise)


def _doubtful(runs: Sequence[RunScores]) -> Iterator[tuple[str, int]]:
    """Run and place of presses whose skin grew against the contact unlike that of the others of their design."""
    for design in dict.fromkeys((run.condition, run.angle_deg) for run in runs):
        presses = {
            f"{run.name} {r}": (
                run.name,
                r,
                Stretch(curve.stretch_force_n, curve.stretch_log_ratio, curve.stretch_log_sd),
            )
            for run in runs
            if (run.condition, run.angle_deg) == design
            for r, curve in enumerate(run.curves)
            if curve.stretch_force_n.size
        }
        for name in unlike_others({name: stretch for name, (_, _, stretch) in presses.items()}):
            yield presses[name][:2]


def _other_rates(study: Study, runs: Sequence[RunScores]) -> tuple[str, tuple[RunScores, ...]] | None:
    """The runs with spread rates by the other rule; None where the study's sums over frames, or stored no curves."""
    name, rule = study.scoring.algorithm, _RATES.get(study.scoring.recipe.rate)
    if rule is None or not any(curve.force_n.size for run in runs for curve in run.curves):
        return None
    window = study.scoring.force_n
    return f"rate by {rule}", tuple(
        replace(run, casr=run.casr | {name: np.array([_rate(curve, rule, window) for curve in run.curves])})
        for run in runs
    )


def _rate(curve: PressCurve, rule: str, window_n: tuple[float, float]) -> float:
    with suppress(CasrError):
        return spread_rate(curve.area_mm2, curve.force_n, rule=rule, window_n=window_n).value
    return np.nan
