"""Kappa: the stiffness of the new specimen by the pins, at one angle under one condition."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from emg2vsa.pipeline.shared_settings import own_domes
from emg2vsa.pipeline.stage import Given, Input, Keyed, Stage

if TYPE_CHECKING:
    from emg2vsa.calibration.results import DesignByPins
    from emg2vsa.pipeline.campaign import Campaign


def settings(campaign: Campaign, item: str) -> dict[str, Any]:
    """Of the specimens that are pressed there alone; the true stiffness of the new one enters nothing here."""
    study, source = campaign.study, campaign.study.runs_source
    pressed = {campaign.runs[key].specimen for key in campaign.designs[item]}
    known = pressed - {study.profile.new_specimen}
    kappa, errors = ({specimen: of[specimen] for specimen in sorted(known & of.keys())} for of in study.kappa_of_scores)
    heights = {specimen: height for specimen, height in sorted(study.heights_mm.items()) if specimen in pressed}
    return {
        "specimens": kappa,
        "standard errors": errors,
        "new_specimen": study.profile.new_specimen,
        "confidence": study.calibration.confidence,
        "mounting_sd_percent": study.calibration.mounting_sd_percent,
        "heights_mm": heights,
        **({"domes": Keyed(str(source.domes), source.domes.name)} if source and source.domes else {}),
    }


def takes(campaign: Campaign, item: str) -> list[Input]:
    return [("runs", key) for key in campaign.designs[item]]


def run(given: Given) -> DesignByPins:
    """DataError : none of its runs was scored."""
    from emg2vsa.calibration.by_pins import design_by_pins
    from emg2vsa.errors import DataError
    from emg2vsa.run_scores.domes import Domes

    used, scores = given.settings, given.all("runs")
    if not scores:
        raise DataError(given.item, wanted="one scored run or more", found="none", do="See why its runs failed.")
    folder, heights = used.get("domes"), used["heights_mm"]
    return design_by_pins(
        scores, used["specimens"], used["new_specimen"], kappa_se=used["standard errors"],
        domes={each.specimen: Domes(folder, heights.get(each.specimen)) for each in scores},
        confidence=used["confidence"], mounting_sd_percent=used["mounting_sd_percent"],
    )  # fmt: skip


STAGE = Stage(
    per="design", of="runs", needs=("runs",), run=run, loads=("emg2vsa.calibration.by_pins",),
    settings=settings, files=own_domes, takes=takes, gives="The stiffness of the new specimen by the pins is",
)  # fmt: skip
