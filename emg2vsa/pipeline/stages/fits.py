"""Fits: a and b of every trial of one recording."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from emg2vsa.pipeline.stage import Given, Input, Keyed, Stage

if TYPE_CHECKING:
    from emg2vsa.fits import Fits
    from emg2vsa.pipeline.campaign import Campaign
    from emg2vsa.settings import CocontractionSettings, PressJudgement

    Judgements = tuple[PressJudgement, ...]


def settings(campaign: Campaign, item: str) -> dict[str, Any]:
    study = campaign.study
    window = campaign.recordings[item].window
    participant = campaign.recordings[item].participant
    judged = tuple(own for own in study.judgements if own.participant == participant)
    used: dict[str, Any] = {
        "fit": study.fit,
        "window.force_n": Keyed(window, window.force_n),
        "judgements": Keyed(judged, _that_count(judged, campaign.recordings[item].specimen, study.cocontraction)),
    }
    return used | ({"cocontraction": study.cocontraction} if study.cocontraction.needs_session else {})


def _that_count(judged: Judgements, specimen: str, cocontraction: CocontractionSettings) -> Judgements:
    """Judgements of a session that a recording depends on: its own, or all where levels are the session's."""
    return judged if cocontraction.needs_session else tuple(own for own in judged if own.specimen == specimen)


def takes(campaign: Campaign, item: str) -> list[Input]:
    """Its own trials; those of the participant's whole session where activity is a share of the session's largest."""
    participant = campaign.recordings[item].participant
    session = campaign.study.cocontraction.needs_session
    return [("trials", cell) for cell in (campaign.cells[participant] if session else (item,))]


def run(given: Given) -> Fits:
    from emg2vsa.fits import fit_trials, in_session

    judgements = given.settings["judgements"]
    session = given.all("trials")
    own = next(trials for trials in session if f"{trials.participant}/{trials.specimen}" == given.item)
    if "cocontraction" in given.settings:
        own = in_session(own, session, given.settings["cocontraction"], judgements)
    return fit_trials(own, given.settings["fit"], given.settings["window.force_n"], judgements)


STAGE = Stage(per="recording", of="people", needs=("trials",), run=run, settings=settings, takes=takes, alone=200)
