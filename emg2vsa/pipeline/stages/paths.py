"""Paths: the verdicts of all claims along other paths of analysis. Only ``emg2vsa run --paths`` runs it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from emg2vsa.pipeline.stage import Given, Keyed, Stage

if TYPE_CHECKING:
    from emg2vsa.multiverse import Paths
    from emg2vsa.pipeline.campaign import Campaign

USED = (
    "participants", "specimens", "judgements", "cocontraction", "fit", "window", "hypotheses", "profile", "schedule",
    "scoring", "calibration", "claims",
)  # fmt: skip
"""Parts of a study that the paths depend on, besides the results that they take."""


def settings(campaign: Campaign, item: str) -> dict[str, Any]:
    study = campaign.study
    used = {name: getattr(study, name) for name in USED}
    return {"study": Keyed(study, used | {"recordings": list(campaign.recordings)})}


def run(given: Given) -> Paths:
    from emg2vsa.hypotheses import Hypotheses
    from emg2vsa.multiverse import all_paths
    from emg2vsa.screening import Screening

    fitted = {(str(fits.participant[0]), str(fits.specimen[0])) for fits in given.each("fits") if fits.participant.size}
    screening, use = given.one("screening") or Screening(), given.settings["study"].hypotheses.use
    cells = {cell for cell in fitted if screening.counts(*cell, use)}
    trials = [trials for trials in given.each("trials") if (trials.participant, trials.specimen) in cells]
    hypotheses: Hypotheses | None = given.one("hypotheses")
    profiles, tested, calibration = (given.one(name) for name in ("profiles", "discrimination", "calibration"))
    return all_paths(
        given.settings["study"], trials, hypotheses.places() if hypotheses else {}, given.all("runs"),
        tested.table if tested else None, calibration=calibration if calibration and calibration.conditions else None,
        participant=profiles.participant if profiles else "",
    )  # fmt: skip


STAGE = Stage(
    per="study", of="report", run=run, settings=settings, on_request=True,
    needs=("trials", "fits", "screening", "hypotheses", "profiles", "runs", "discrimination", "calibration"),
    gives="The paths of analysis are",
)  # fmt: skip
