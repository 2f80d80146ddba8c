"""The stages in running order, and which steps of a study each has. A new stage is one file and one line here."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

from emg2vsa.pipeline.stage import Input, Stage

if TYPE_CHECKING:
    from emg2vsa.pipeline.campaign import Campaign
    from emg2vsa.study import Study

ORDER = (
    "trials",
    "fits",
    "screening",
    "pages",
    "hypotheses",
    "exemplary",
    "profiles",
    "schedules",
    "stiffness",
    "emulation",
    "runs",
    "discrimination",
    "kappa",
    "calibration",
    "paths",
    "report",
)
"""Each is the file of that name in ``emg2vsa/pipeline/stages``."""
PART_REPORTS = ("people_report", "rig_report")
"""Reports of one part of a study that has both parts: results beside the whole report, which removes none of them."""
REPORTS = ("report", *PART_REPORTS)


def stage(name: str) -> Stage:
    """The stage of that name, imported when it is first asked for."""
    path = module_of(name)
    module = sys.modules.get(path) or importlib.import_module(path)  # asked thousands of times
    found: Stage = module.PART_STAGES[name] if name in PART_REPORTS else module.STAGE
    return found


def module_of(name: str) -> str:
    """Module that declares the stage; the code of its results is what this module reaches."""
    return f"emg2vsa.pipeline.stages.{'report' if name in PART_REPORTS else name}"


def stages_for(wanted: str | None) -> tuple[str, ...]:
    """The wanted stage and all it needs, in running order; every stage when nothing is named."""
    return ORDER if wanted is None else with_needs({wanted})


def stages_of(part: Literal["people", "rig"], study: Study) -> tuple[str, ...]:
    """Everything about people, or the rig's runs with what they need; each with its report.

    The only part that a study has is the whole study, so its report is the whole report.
    """
    own = {name for name in ORDER if stage(name).of in ({"people"} if part == "people" else {"emulated rig", "runs"})}
    both = study.recordings and study.runs_source is not None
    return (*(name for name in with_needs(own) if name != "report"), f"{part}_report" if both else "report")


def needs_runs(stages: Sequence[str]) -> bool:
    """Whether one of the stages is about the rig's runs."""
    return any(stage(name).of in ("emulated rig", "runs") for name in stages)


def with_needs(names: set[str]) -> tuple[str, ...]:
    """These stages and all that they need, in running order."""
    wanted = set(names)
    for name in reversed(ORDER):
        if name in wanted:
            wanted.update(stage(name).needs)
    return tuple(name for name in ORDER if name in wanted)


def items(campaign: Campaign, name: str) -> tuple[str, ...]:
    """The items of a stage in this study, in the study's order."""
    absent = {
        "people": not campaign.study.recordings,
        "emulated rig": campaign.rig is None,
        "runs": not campaign.study.runs,
        "report": False,
    }
    if absent[stage(name).of]:
        return ()
    match stage(name).per:
        case "recording":
            return tuple(campaign.recordings)
        case "run":
            return tuple(campaign.runs)
        case "mounting":
            return tuple(campaign.mountings)
        case "design":
            return tuple(campaign.designs)
        case "participant":
            return tuple(campaign.cells)
        case _:
            return ("study",)


def inputs(campaign: Campaign, name: str, item: str) -> Sequence[Input]:
    """The steps whose results the step takes, some of which the study may not have."""
    own = stage(name)
    if own.takes is not None:
        return own.takes(campaign, item)
    taken: list[Input] = []
    for need in own.needs:
        if stage(need).per == own.per and own.per != "study":
            taken.append((need, item))
        elif own.per == "participant" and stage(need).per != "study":
            taken += [(need, cell) for cell in campaign.cells[item]]
        else:
            taken += [(need, other) for other in items(campaign, need)]
    return taken
