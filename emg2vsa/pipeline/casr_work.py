"""The steps on all runs of the rig: the tests on their scores, and the stiffness of the new specimen."""

from __future__ import annotations

from pathlib import Path

from emg2vsa import artifacts
from emg2vsa.calibration.runs_calibration import calibrate_runs
from emg2vsa.discrimination import discriminate
from emg2vsa.pipeline.study_work import Inputs, stored
from emg2vsa.pipeline.tasks import Ended, guarded
from emg2vsa.study import Study


def discrimination(study: Study, inputs: Inputs, result: Path) -> list[Ended]:
    """The tests on initial areas and spread rates."""

    def make() -> object:
        runs = [artifacts.load(path) for path in inputs["runs"]]
        return discriminate(runs, study.pressed_n_per_mm, study.profile.new_specimen or "", study.discrimination)

    return stored("discrimination", result, make)


def calibration(study: Study, inputs: Inputs, result: Path) -> list[Ended]:
    """Stiffness of the new specimen from its spread rate."""

    def make() -> str:
        runs = [artifacts.load(path) for path in inputs["runs"]]
        found = calibrate_runs(
            runs,
            study.pressed_n_per_mm,
            study.profile.new_specimen or "",
            study.calibration,
            kappa_se=study.pressed_se_n_per_mm,
        )
        artifacts.save(result, found)
        return "" if found.conditions else " ".join(found.notes)

    return [guarded("calibration/study", make)]
