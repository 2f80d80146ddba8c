"""The results of a study as DataFrames."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from os import PathLike
from typing import Any

import numpy as np
import pandas as pd

from emg2vsa import __version__, artifacts
from emg2vsa.calibration.results import CalibrationResults, ConditionResult, LawResult
from emg2vsa.errors import DataError, SettingError
from emg2vsa.fits import concatenate
from emg2vsa.pipeline.plan import StepPlan, survey
from emg2vsa.pipeline.run_study import Progress, run_study
from emg2vsa.pipeline.stage_order import ORDER, stages_for
from emg2vsa.process_pool import available_cores
from emg2vsa.public.given import file_of, plain
from emg2vsa.public.recordings import fits_frame, samples_frame, trials_frame
from emg2vsa.public.schedules import profiles_frame, schedules_frame
from emg2vsa.public.tests import outcomes_frame
from emg2vsa.report.sections.hypothesis_tables import outcomes
from emg2vsa.run_scores import RunScores
from emg2vsa.screening import Screening, screened
from emg2vsa.study import Study
from emg2vsa.study_file import load_study
from emg2vsa.study_file.problems import shown

StudyFile = str | PathLike[str]


class _Table:
    """A table that is made when it is first asked for; whoever asks gets a copy of their own."""

    def __init__(self, make: Callable[[Results], pd.DataFrame]) -> None:
        self._make, self.__doc__ = make, make.__doc__

    def __get__(self, results: Results | None, owner: type) -> pd.DataFrame:
        if results is None:
            return self  # type: ignore[return-value]  # as a property of the class, for its documentation
        made = results._made
        if self._make.__name__ not in made:
            made[self._make.__name__] = self._make(results)
        return made[self._make.__name__].copy()


class Results:
    """What is stored of a study; every table is read when it is first asked for.

    Only results that are up to date are there: of a step that is stale, waits or failed there is no row, and
    ``attrs["left_out"]`` names it. ``attrs`` also holds the study, its mode, the stage and the digests of the results.

    Every table raises DataError where the study has no result of that kind: run it first.
    """

    def __init__(self, plan: StepPlan) -> None:
        self._plan = plan
        self._made: dict[str, pd.DataFrame] = {}
        self.study: Study = plan.study

    def __repr__(self) -> str:
        there = [name for name in ORDER if self._plan.done(name)]
        return f"Results({self.study.name!r}, {self.study.mode} mode: {', '.join(there) or 'nothing yet'})"

    @_Table
    def steps(self) -> pd.DataFrame:
        """Every step: stage, item, status (fresh, stale, waits, failed, blocked), reasons, message."""
        rows = [(s.stage, s.item, s.status, "; ".join(s.reasons), s.message) for s in self._plan.steps.values()]
        return pd.DataFrame(rows, columns=["stage", "item", "status", "reasons", "message"])

    @_Table
    def trials(self) -> pd.DataFrame:
        """The presses of people, one row each, as `emg2vsa.trials` gives them."""
        return self._joined("trials", trials_frame)

    @_Table
    def samples(self) -> pd.DataFrame:
        """The conditioned samples within all presses: force, activity and envelopes, as `emg2vsa.samples`."""
        return self._joined("trials", samples_frame)

    @_Table
    def fits(self) -> pd.DataFrame:
        """v = a + b ln(F / 1 N) of every press of people, as `emg2vsa.fit` gives it.

        Presses of recordings that are unlike all others of the study have the verdict that the tests take.
        """
        screening = next((artifacts.load(path) for path in self._plan.done("screening")), Screening())
        found = fits_frame(concatenate(screened(each, screening) for each in self._all("fits")))
        found.attrs |= self._origin("fits")
        return found

    @_Table
    def tests(self) -> pd.DataFrame:
        """The tests on b, one row each, as `emg2vsa.stats` gives them."""
        (found,) = self._all("hypotheses")
        return self._told(outcomes_frame(outcomes(found)), "hypotheses")

    @_Table
    def profiles(self) -> pd.DataFrame:
        """Mean co-contraction against force of every specimen and of the one nobody palpated."""
        (found,) = self._all("profiles")
        return self._told(profiles_frame(found), "profiles")

    @_Table
    def schedules(self) -> pd.DataFrame:
        """Stiffness schedules, one row a step of force, as `emg2vsa.schedule` gives them."""
        (found,) = self._all("schedules")
        return self._told(schedules_frame(found), "schedules")

    @_Table
    def scores(self) -> pd.DataFrame:
        """Presses of the rig, one row a press and vision algorithm: A_c0, CASR, and what else was measured."""
        return self._joined("runs", _scores_frame)

    @_Table
    def calibration(self) -> pd.DataFrame:
        """kappa of the new specimen with its interval, one row an angle, condition, algorithm and law."""
        (found,) = self._all("calibration")
        return self._told(_calibration_frame(found), "calibration")

    def _all(self, stage: str) -> list[Any]:
        paths = self._plan.done(stage)
        if not paths:
            failed = [f"{s.id}: {s.message}" for s in self._plan.steps.values() if s.stage == stage and s.message]
            raise DataError(
                self.study.path, wanted=f"results of the stage {stage} that are up to date",
                found=failed[0] if failed else "none",
                do="Run the study: emg2vsa run STUDY, or emg2vsa.run(STUDY).",
            )  # fmt: skip
        return [artifacts.load(path) for path in paths]

    def _joined(self, stage: str, frame: Callable[[Any], pd.DataFrame]) -> pd.DataFrame:
        parts = [frame(product) for product in self._all(stage)]
        for part in parts:
            part.attrs = {}  # joining compares them, part by part
        return self._told(pd.concat(parts, ignore_index=True), stage)

    def _told(self, frame: pd.DataFrame, stage: str) -> pd.DataFrame:
        frame.attrs |= self._origin(stage)
        return frame

    def _origin(self, stage: str) -> dict[str, Any]:
        steps = [step for step in self._plan.steps.values() if step.stage == stage]
        there = {step.item: step.result for step in steps if step.status in ("fresh", "done")}
        return {
            "study": str(self.study.path), "mode": self.study.mode, "stage": stage, "emg2vsa": __version__,
            "results": there, "left_out": [step.item for step in steps if step.item not in there],
        }  # fmt: skip


def load(study: StudyFile) -> Results:
    """The stored results of a study; nothing is computed, and nothing but the memory of files is written.

    StudyError : the study file has problems.
    """
    return Results(survey(_study_of(study), ORDER, lambda text: None))


def run(study: StudyFile, *, only: str | None = None, jobs: int | None = None, paths: bool = False) -> Results:
    """Bring a study up to date, as ``emg2vsa run``, and load its results.

    only : stop after this stage.
    jobs : processes; all cores where it is None (a script then needs the usual ``if __name__ == "__main__"``).
    paths : also how far each verdict hangs on choices of analysis.
    DataError : no such stage. SettingError : ``jobs`` or ``paths`` that cannot be.
    """
    if only is not None and only not in ORDER:
        raise DataError("only", wanted=f"one of {', '.join(ORDER)}", found=repr(only), do="Choose one of these.")
    jobs = plain(jobs)
    if jobs is not None and (not isinstance(jobs, int) or isinstance(jobs, bool) or jobs < 1):
        do = "Choose a number of processes, or leave it out for all cores."
        raise SettingError("jobs", wanted="a whole number from 1", found=shown(jobs), do=do)
    silent = Progress(lambda stage, total: None, lambda step: None, lambda: None, lambda text: None)
    if not isinstance(paths, bool):
        raise SettingError("paths", wanted="True or False", found=shown(paths), do="Leave it out for False.")
    asked = ("paths",) if paths or only == "paths" else ()
    run_study(_study_of(study), stages=stages_for(only), jobs=jobs or available_cores(), progress=silent, asked=asked)
    return load(study)


def _study_of(file: StudyFile) -> Study:
    return load_study(file_of(file, "study", "the path of a study file"))


def _scores_frame(run: RunScores) -> pd.DataFrame:
    unit = run.area_unit
    parts = []
    for algorithm in run.casr:
        parts.append(
            pd.DataFrame(
                {
                    "specimen": run.specimen, "angle_deg": run.angle_deg, "condition": run.condition,
                    "mounting": run.mounting, "repetition": run.repetitions, "algorithm": algorithm,
                    "chosen": algorithm == run.algorithm, "verdict": list(run.verdicts), "reason": list(run.reasons),
                    f"a_c0_{unit}": run.a_c0[algorithm], f"start_area_{unit}": run.start_area[algorithm],
                    f"casr_{unit}_per_n": run.casr[algorithm], "peak_force_n": run.peak_n,
                    "indentation_n_per_mm": run.indent_n_per_mm, "simulated": run.simulated,
                }
            )
        )  # fmt: skip
    return pd.concat(parts, ignore_index=True)


def _calibration_frame(found: CalibrationResults) -> pd.DataFrame:
    rows = [row for condition in found.conditions for row in _laws(condition)]
    frame = pd.DataFrame(rows)
    frame.attrs = {
        "new_specimen": found.new_specimen, "known_kappa_n_per_mm": found.known_kappa_new, "notes": list(found.notes),
    }  # fmt: skip
    return frame


def _laws(condition: ConditionResult) -> Iterator[dict[str, Any]]:
    shared = {"angle_deg": condition.angle_deg, "condition": condition.condition, "simulated": condition.simulated}
    if (pins := condition.pins) is not None:
        yield shared | {
            "cue": ", ".join(pins.by_cue), "by": "pins", "kappa_n_per_mm": pins.kappa, "kappa_lo_n_per_mm": pins.low,
            "kappa_hi_n_per_mm": pins.high, "determined": pins.determined, "relative_error": pins.error,
            "notes": "; ".join(pins.notes),
        }  # fmt: skip
    for name, algorithm in condition.algorithms.items():
        yield shared | {"cue": name, "by": "chosen"} | _law(algorithm.chosen)
        yield shared | {"cue": name, "by": "paper"} | _law(algorithm.paper)
        if (fused := algorithm.fused) is not None:
            yield shared | {
                "cue": f"{name} + indentation", "by": "fused", "kappa_n_per_mm": fused.kappa,
                "kappa_lo_n_per_mm": fused.low, "kappa_hi_n_per_mm": fused.high, "relative_error": fused.error,
                "notes": "; ".join(fused.notes),
            }  # fmt: skip
    if condition.indentation is not None:
        yield shared | {"cue": "indentation", "by": "chosen"} | _law(condition.indentation)


def _law(law: LawResult) -> dict[str, Any]:
    known = np.isfinite(law.kappa)
    return {
        "law": law.law, "kappa_n_per_mm": law.kappa, "kappa_lo_n_per_mm": law.low, "kappa_hi_n_per_mm": law.high,
        "determined": bool(law.determined and known), "relative_error": law.error, "r2": law.r2,
        "adj_r2": law.adj_r2, "equation": law.equation, "notes": "; ".join(law.notes),
    }  # fmt: skip
