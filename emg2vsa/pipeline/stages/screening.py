"""Screening: recordings that are unlike all others of the study. Of each only its traits are kept."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from emg2vsa.pipeline.stage import Given, Keyed, Stage

if TYPE_CHECKING:
    from emg2vsa.pipeline.campaign import Campaign
    from emg2vsa.screening import Screening


def settings(campaign: Campaign, item: str) -> dict[str, Any]:
    """What people said of whole recordings."""
    judged = tuple(own for own in campaign.study.judgements if own.repetition is None and not own.excludes)
    return {"accepted": Keyed(judged, sorted((own.participant, own.specimen) for own in judged))}


def run(given: Given) -> Screening:
    from emg2vsa.screening.screen import screen, traits_by_recording, visits_of

    visits = {(trials.participant, trials.specimen): visits_of(trials) for trials in given.each("trials")}
    return screen(traits_by_recording(given.each("trials")), given.settings["accepted"], visits)


def says(screening: Screening) -> str:
    """The certain ones; the others stand with their sessions."""
    return "; ".join(
        f"{each.participant}/{each.specimen}: {each.said}" for each in screening.found if each.verdict == "unreadable"
    )


STAGE = Stage(
    per="study", of="people", needs=("trials",), run=run, settings=settings, says=says,
    gives="The comparison of the recordings is",
)  # fmt: skip
