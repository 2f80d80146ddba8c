"""Report of ``emg2vsa run --human-only``, in a folder of its own: what people do, without the runs of a rig."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from emg2vsa.pipeline.stages import report

if TYPE_CHECKING:
    from emg2vsa.pipeline.campaign import Campaign
    from emg2vsa.pipeline.stage import Given

FOLDER = "people"


def folder(campaign: Campaign, item: str) -> Path:
    return campaign.study.reports / FOLDER


def run(given: Given) -> list[Path]:
    return report.write(given, "../participants")


STAGE = replace(
    report.STAGE,
    run=run,
    needs=("trials", "fits", "pages", "hypotheses", "exemplary", "profiles", "schedules"),
    folder=folder,
)
