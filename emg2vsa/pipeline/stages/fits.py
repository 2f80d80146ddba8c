"""Fits: a and b of every trial of one recording."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from emg2vsa.pipeline.stage import Given, Input, Keyed, Stage

if TYPE_CHECKING:
    from emg2vsa.fits import Fits
    from emg2vsa.pipeline.campaign import Campaign


def settings(campaign: Campaign, item: str) -> dict[str, Any]:
    study = campaign.study
    window = campaign.recordings[item].window
    used: dict[str, Any] = {"fit": study.fit, "window.force_n": Keyed(window, window.force_n)}
    return used | ({"cocontraction": study.cocontraction} if study.cocontraction.needs_session else {})


def takes(campaign: Campaign, item: str) -> list[Input]:
    """Its own trials; those of the participant's whole session where activity is a share of the session's largest."""
    participant = campaign.recordings[item].participant
    session = campaign.study.cocontraction.needs_session
    return [("trials", cell) for cell in (campaign.cells[participant] if session else (item,))]


def run(given: Given) -> Fits:
    from emg2vsa.fits import fit_trials, in_session

    session = given.all("trials")
    own = next(trials for trials in session if f"{trials.participant}/{trials.specimen}" == given.item)
    if "cocontraction" in given.settings:
        own = in_session(own, session, given.settings["cocontraction"])
    return fit_trials(own, given.settings["fit"], given.settings["window.force_n"])


STAGE = Stage(per="recording", of="people", needs=("trials",), run=run, settings=settings, takes=takes, alone=200)
