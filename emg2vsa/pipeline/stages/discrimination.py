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
    }


def run(given: Given) -> Discrimination:
    from emg2vsa.discrimination import discriminate

    used = given.settings
    return discriminate(
        given.all("runs"), used["specimens"], used["new_specimen"], used["discrimination"],
        mounting_sd=used["mounting_sd_percent"] / 100,
    )  # fmt: skip


STAGE = Stage(
    per="study", of="runs", needs=("runs",), run=run, settings=settings, gives="The tests on areas and spread rates are"
)
