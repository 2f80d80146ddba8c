"""Calibration: the stiffness of the new specimen from its spread rate."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from emg2vsa.pipeline.stage import Given, Stage

if TYPE_CHECKING:
    from emg2vsa.calibration.results import CalibrationResults
    from emg2vsa.pipeline.campaign import Campaign


def settings(campaign: Campaign, item: str) -> dict[str, Any]:
    study = campaign.study
    return {
        "calibration": study.calibration,
        "specimens": study.pressed_n_per_mm,
        "standard errors": study.pressed_se_n_per_mm,
        "new_specimen": study.profile.new_specimen or "",
    }


def run(given: Given) -> CalibrationResults:
    from emg2vsa.calibration.runs_calibration import calibrate_runs

    used = given.settings
    return calibrate_runs(
        given.all("runs"), used["specimens"], used["new_specimen"], used["calibration"],
        kappa_se=used["standard errors"],
    )  # fmt: skip


def says(results: CalibrationResults) -> str:
    return "" if results.conditions else " ".join(results.notes)


STAGE = Stage(
    per="study",
    of="runs",
    needs=("runs",),
    run=run,
    settings=settings,
    says=says,
    gives="The stiffness of the new specimen is",
)
