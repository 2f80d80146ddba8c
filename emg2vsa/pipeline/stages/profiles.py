"""Profiles: mean trends of the specimens, and a specimen that nobody palpated."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from emg2vsa.pipeline.stage import Given, Keyed, Stage

if TYPE_CHECKING:
    from emg2vsa.pipeline.campaign import Campaign
    from emg2vsa.profiles import Profiles


def settings(campaign: Campaign, item: str) -> dict[str, Any]:
    study = campaign.study
    return {
        "profile": study.profile,
        "specimens": study.stiffness_n_per_mm,
        "hypotheses.use": study.hypotheses.use,
        "window.force_n": Keyed(study.window, study.window.force_n),
    }


def run(given: Given) -> Profiles:
    from emg2vsa.fits import concatenate
    from emg2vsa.profiles import build_profiles
    from emg2vsa.screening import screened

    used, screening = given.settings, given.one("screening")
    fits = (screened(each, screening) for each in given.each("fits"))
    return build_profiles(
        concatenate(fits, bins=False), used["specimens"], used["profile"], used["window.force_n"],
        used["hypotheses.use"], given.one("exemplary"),
    )  # fmt: skip


STAGE = Stage(
    per="study",
    of="people",
    needs=("fits", "screening", "exemplary"),
    run=run,
    settings=settings,
    gives="The mean profiles are",
)
