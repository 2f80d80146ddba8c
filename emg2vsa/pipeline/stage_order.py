"""The stages in running order, and which steps of a study each has. A new stage is one file and one line here."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

from emg2vsa.pipeline.stage import Input, Stage

if TYPE_CHECKING:
    from emg2vsa.pipeline.campaign import Campaign

ORDER = (
    "trials",
    "fits",
    "pages",
    "hypotheses",
    "profiles",
    "schedules",
    "emulation",
    "runs",
    "discrimination",
    "calibration",
    "report",
)
"""Each is the file of that name in ``emg2vsa/pipeline/stages``."""


def stage(name: str) -> Stage:
    """The stage of that name, imported when it is first asked for."""
    found: Stage = importlib.import_module(module_of(name)).STAGE
    return found


def module_of(name: str) -> str:
    """Module that declares the stage; the code of its results is what this module reaches."""
    return f"emg2vsa.pipeline.stages.{name}"


def stages_for(wanted: str | None) -> tuple[str, ...]:
    """The wanted stage and all it needs, in running order; every stage when nothing is named."""
    return ORDER if wanted is None else _with_needs({wanted})


def stages_of(part: Literal["people", "rig"]) -> tuple[str, ...]:
    """Everything about people, or the rig's runs with what they need; each with its report."""
    own = {name for name in ORDER if stage(name).of in ({"people"} if part == "people" else {"emulated rig", "runs"})}
    return (*(name for name in _with_needs(own) if name != "report"), "report")


def needs_runs(stages: Sequence[str]) -> bool:
    """Whether one of the stages is about the rig's runs."""
    return any(stage(name).of in ("emulated rig", "runs") for name in stages)


def _with_needs(names: set[str]) -> tuple[str, ...]:
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
        elif own.per == "participant":
            taken += [(need, cell) for cell in campaign.cells[item]]
        else:
            taken += [(need, other) for other in items(campaign, need)]
    return taken
