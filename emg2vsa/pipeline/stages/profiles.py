"""Profiles: mean trends of the specimens, and a specimen that nobody palpated."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from emg2vsa.pipeline.shared_settings import profile_settings
from emg2vsa.pipeline.stage import Given, Stage

if TYPE_CHECKING:
    from collections.abc import Iterator

    from emg2vsa.curves.monotone_spline import MonotoneSpline
    from emg2vsa.fits import Fits
    from emg2vsa.pipeline.campaign import Campaign
    from emg2vsa.profiles import Profiles


def settings(campaign: Campaign, item: str) -> dict[str, Any]:
    return profile_settings(campaign, campaign.study.profile)


def run(given: Given) -> Profiles:
    """One recording at a time: of its force bins only their spline is kept."""
    from emg2vsa.fits import concatenate
    from emg2vsa.profiles import build_profiles
    from emg2vsa.profiles.splines import cell_splines
    from emg2vsa.screening import screened

    used, screening = given.settings, given.one("screening")
    use, window = used["hypotheses.use"], used["window.force_n"]
    splines: dict[tuple[str, str], MonotoneSpline] = {}

    def recordings() -> Iterator[Fits]:
        for each in given.each("fits"):
            fits = screened(each, screening)
            splines.update(cell_splines(fits, use, window.force_n))
            yield fits

    fits = concatenate(recordings(), bins=False)
    return build_profiles(fits, used["specimens"], used["profile"], window, use, given.one("exemplary"), splines)


STAGE = Stage(
    per="study",
    of="people",
    needs=("fits", "screening", "exemplary"),
    run=run,
    settings=settings,
    gives="The mean profiles are",
)
