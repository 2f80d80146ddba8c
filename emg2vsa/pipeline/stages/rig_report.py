"""Report of ``emg2vsa run --casr-only``, in a folder of its own: the rig's runs, and the schedules behind them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from emg2vsa.pipeline.stages import report

if TYPE_CHECKING:
    from emg2vsa.pipeline.campaign import Campaign
    from emg2vsa.pipeline.stage import Given

FOLDER = "rig"


def folder(campaign: Campaign, item: str) -> Path:
    return campaign.study.reports / FOLDER


def run(given: Given) -> list[Path]:
    return report.write(given, "")


STAGE = replace(
    report.STAGE,
    run=run,
    needs=(
        "trials",
        "fits",
        "exemplary",
        "profiles",
        "schedules",
        "stiffness",
        "emulation",
        "runs",
        "discrimination",
        "calibration",
    ),
    folder=folder,
)
