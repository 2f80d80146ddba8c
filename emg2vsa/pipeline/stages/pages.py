"""Pages: one for each participant, for the person who runs the session."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from emg2vsa.pipeline.stage import Given, Keyed, Stage

if TYPE_CHECKING:
    from emg2vsa.pipeline.campaign import Campaign


def settings(campaign: Campaign, item: str) -> dict[str, Any]:
    """The study less all other participants; of it the page shows title, specimens and recordings."""
    own = tuple(campaign.recordings[cell] for cell in campaign.cells[item])
    judged = tuple(each for each in campaign.study.judgements if each.participant == item)
    study = replace(campaign.study, participants=(item,), recordings=own, runs=(), judgements=judged)
    shown = {"title": study.title, "specimens": study.specimens, "recordings": own, "judgements": judged}
    return {"study": Keyed(study, shown)}


def folder(campaign: Campaign, item: str) -> Path:
    return campaign.study.reports


def run(given: Given) -> list[Path]:
    from emg2vsa.fits import concatenate
    from emg2vsa.report.failures import Failure
    from emg2vsa.report.session_page import write_session_page
    from emg2vsa.screening import screened, screened_trials

    assert given.folder is not None
    screening = given.one("screening")
    fits = [screened(each, screening) for each in given.each("fits")]
    trials = [screened_trials(each, screening) for each in given.each("trials")]
    failures = tuple(Failure(*failure) for failure in given.failures)
    return write_session_page(
        given.settings["study"], given.item, trials, concatenate(fits) if fits else None, failures,
        given.folder,
    )  # fmt: skip


STAGE = Stage(
    per="participant", of="people", needs=("trials", "fits", "screening"), run=run, settings=settings, folder=folder,
    tells_failures=True, alone=64,
)  # fmt: skip
