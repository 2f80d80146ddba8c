"""Calibration: the stiffness of the new specimen from its spread rate, beside that by the pins."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from emg2vsa.pipeline.shared_settings import own_domes
from emg2vsa.pipeline.stage import Given, Keyed, Stage

if TYPE_CHECKING:
    from emg2vsa.calibration.results import CalibrationResults, ConditionResult
    from emg2vsa.pipeline.campaign import Campaign


def settings(campaign: Campaign, item: str) -> dict[str, Any]:
    study = campaign.study
    domes = study.runs_source.domes if study.runs_source else None
    kappa, errors = study.kappa_of_scores
    return {
        "calibration": study.calibration,
        "specimens": kappa,
        "standard errors": errors,
        "new_specimen": study.profile.new_specimen or "",
        "force_n": study.scoring.force_n,
        "study": study.name,
        "mode": study.mode,
        "algorithm": study.scoring.algorithm,
        "heights_mm": study.heights_mm,
        **({"domes": Keyed(str(domes), domes.name)} if domes else {}),
    }


def run(given: Given) -> CalibrationResults:
    from dataclasses import replace

    import emg2vsa
    from emg2vsa.calibration.runs_calibration import calibrate_runs, online_calibrations
    from emg2vsa.run_scores.domes import Domes

    used, scores = given.settings, given.all("runs")
    specimens, new, settings, errors = (
        used[name] for name in ("specimens", "new_specimen", "calibration", "standard errors")
    )
    provenance = {"study": used["study"], "mode": used["mode"], "emg2vsa": emg2vsa.__version__}
    folder, heights = used.get("domes"), used["heights_mm"]
    provenance |= {"domes": Path(folder).name} if folder else {}
    domes = {each.specimen: Domes(folder, heights.get(each.specimen)) for each in scores}
    found = calibrate_runs(scores, specimens, new, settings, kappa_se=errors, by_pins=given.all("kappa"))
    online = online_calibrations(
        scores, specimens, new, used["force_n"], settings, kappa_se=errors, domes=domes, provenance=provenance,
        found=found,
    )  # fmt: skip
    notes = tuple(
        f"{each.angle_deg:g}°, {each.condition}: no calibration file, because CASR does not rise with softness. "
        "Check the stiffnesses of the specimens."
        for each in online
        if not each.rises
    )
    rising = tuple(each for each in online if each.rises)
    return replace(found, online=rising, notes=(*found.notes, *notes), algorithm=used["algorithm"])


def says(results: CalibrationResults) -> str:
    """The one estimate of each design, or why there is none."""
    told = [f"{each.condition} {each.angle_deg:g}° {_said(each, results)}" for each in results.conditions]
    return f"kappa of {results.new_specimen}, N/mm: {', '.join(told)}" if told else " ".join(results.notes)


def _said(each: ConditionResult, results: CalibrationResults) -> str:
    one = each.headline(results.algorithm)
    if one is None or not one.low <= one.kappa:
        return "none"
    by = "" if each.pins else " by CASR"
    return f"{one.kappa:.3g} [{one.low:.3g}, {one.high:.3g}]{by}{'' if one.determined else ' not determined'}"


STAGE = Stage(
    per="study", of="runs", needs=("runs", "kappa"), run=run, settings=settings, files=own_domes, says=says,
    gives="The stiffness of the new specimen is",
)  # fmt: skip
