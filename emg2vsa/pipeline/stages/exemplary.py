"""Exemplary: how far the participants' schedules are apart, and which participant is the medoid.

A stage of its own, so that a change in one participant's recordings goes no further than it changes the profiles.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from emg2vsa.pipeline.shared_settings import profile_settings
from emg2vsa.pipeline.stage import Given, Stage

if TYPE_CHECKING:
    from emg2vsa.exemplary import Choice
    from emg2vsa.pipeline.campaign import Campaign


def settings(campaign: Campaign, item: str) -> dict[str, Any]:
    profile = campaign.study.profile
    return profile_settings(campaign, (profile.participant, profile.specimens, profile.grid_points))


def run(given: Given) -> Choice | None:
    """None where fewer than two participants pressed every exported specimen."""
    from emg2vsa.exemplary import compare_participants
    from emg2vsa.fits import concatenate
    from emg2vsa.screening import screened

    used, screening = given.settings, given.one("screening")
    fits = (screened(each, screening) for each in given.each("fits"))
    return compare_participants(
        concatenate(fits, bins=False), used["specimens"], used["profile"], used["window.force_n"],
        used["hypotheses.use"],
    )  # fmt: skip


STAGE = Stage(
    per="study", of="people", needs=("fits", "screening"), run=run, settings=settings,
    gives="The comparison of the participants' schedules is",
)  # fmt: skip
