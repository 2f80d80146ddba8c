"""Schedules: from profiles to the stiffness of the actuator, equations (7) and (8)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from emg2vsa.pipeline.stage import Given, Stage

if TYPE_CHECKING:
    from emg2vsa.pipeline.campaign import Campaign
    from emg2vsa.schedules import Schedule


def settings(campaign: Campaign, item: str) -> dict[str, Any]:
    study = campaign.study
    return {"schedule": study.schedule, "study": study.name, "mode": study.mode}


def run(given: Given) -> tuple[Schedule, ...]:
    """The schedules of all specimens and conditions. DataError : there are no profiles."""
    from emg2vsa import artifacts
    from emg2vsa.errors import DataError
    from emg2vsa.schedules.build import build_schedules

    profiles = given.one("profiles")
    if profiles is None:
        raise DataError("schedules", wanted="profiles", found="none", do="Correct what the step profiles complains of.")
    provenance = {
        "study": given.settings["study"],
        "mode": given.settings["mode"],
        "profiles": artifacts.digest_of(given.inputs["profiles"][0]),
    }
    return build_schedules(profiles, given.settings["schedule"], provenance)


STAGE = Stage(
    per="study", of="people", needs=("profiles",), run=run, settings=settings, gives="The stiffness schedules are"
)
