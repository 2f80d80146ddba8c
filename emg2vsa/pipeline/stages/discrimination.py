"""Discrimination: the tests on initial areas and spread rates."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from emg2vsa.pipeline.stage import Given, Stage

if TYPE_CHECKING:
    from emg2vsa.discrimination import Discrimination
    from emg2vsa.pipeline.campaign import Campaign


def settings(campaign: Campaign, item: str) -> dict[str, Any]:
    study = campaign.study
    return {
        "discrimination": study.discrimination,
        "specimens": study.pressed_n_per_mm,
        "new_specimen": study.profile.new_specimen or "",
        "mounting_sd_percent": study.calibration.mounting_sd_percent,
        "schedule_of": campaign.rig.experiment.schedule_of if campaign.rig else {},
    }


def run(given: Given) -> Discrimination:
    from emg2vsa.discrimination import discriminate

    used = given.settings
    return discriminate(
        given.all("runs"), used["specimens"], used["new_specimen"], used["discrimination"],
        mounting_sd=used["mounting_sd_percent"] / 100,
        schedule_of=used["schedule_of"],
    )  # fmt: skip


def says(found: Discrimination) -> str:
    from emg2vsa.discrimination.contrast_words import contrast_words

    return " ".join(contrast_words(found))


STAGE = Stage(
    per="study", of="runs", needs=("runs",), run=run, settings=settings, says=says,
    gives="The tests on areas and spread rates are",
)  # fmt: skip
