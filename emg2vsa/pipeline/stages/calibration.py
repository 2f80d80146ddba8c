"""Calibration: the stiffness of the new specimen from its spread rate."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from emg2vsa.pipeline.stage import Given, Stage

if TYPE_CHECKING:
    from emg2vsa.calibration.results import CalibrationResults
    from emg2vsa.pipeline.campaign import Campaign


def settings(campaign: Campaign, item: str) -> dict[str, Any]:
    study = campaign.study
    kappa, errors = study.kappa_of_scores
    return {
        "calibration": study.calibration,
        "specimens": kappa,
        "standard errors": errors,
        "new_specimen": study.profile.new_specimen or "",
        "force_n": study.scoring.force_n,
        "study": study.name,
        "mode": study.mode,
        **({"domes": study.runs_source.domes.name} if study.runs_source and study.runs_source.domes else {}),
    }


def run(given: Given) -> CalibrationResults:
    from dataclasses import replace

    import emg2vsa
    from emg2vsa.calibration.runs_calibration import calibrate_runs, online_calibrations

    used, scores = given.settings, given.all("runs")
    specimens, new, settings, errors = (
        used[name] for name in ("specimens", "new_specimen", "calibration", "standard errors")
    )
    provenance = {"study": used["study"], "mode": used["mode"], "emg2vsa": emg2vsa.__version__}
    provenance |= {"domes": used["domes"]} if "domes" in used else {}
    online = online_calibrations(
        scores, specimens, new, used["force_n"], settings, kappa_se=errors, provenance=provenance
    )  # fmt: skip
    found = calibrate_runs(scores, specimens, new, settings, kappa_se=errors)
    notes = tuple(
        f"{each.angle_deg:g}°, {each.condition}: no calibration file, because CASR does not rise with softness. "
        "Check the stiffnesses of the specimens."
        for each in online
        if not each.rises
    )
    return replace(found, online=tuple(each for each in online if each.rises), notes=(*found.notes, *notes))


def says(results: CalibrationResults) -> str:
    return "" if results.conditions else " ".join(results.notes)


STAGE = Stage(
    per="study", of="runs", needs=("runs",), run=run, settings=settings, says=says,
    gives="The stiffness of the new specimen is",
)  # fmt: skip
