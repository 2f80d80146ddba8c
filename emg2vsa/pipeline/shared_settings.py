"""Settings and files that several stages declare, apart from the stages: a stage whose file imports another's would
hang on all that the other one runs."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from emg2vsa.pipeline.stage import Keyed

if TYPE_CHECKING:
    from emg2vsa.devices.device_settings import ActuatorSettings
    from emg2vsa.pipeline.campaign import Campaign


def profile_settings(campaign: Campaign, counts: Any) -> dict[str, Any]:
    """Settings of the stages that compare trends. counts : what of [profile] is part of the key."""
    study = campaign.study
    return {
        "profile": Keyed(study.profile, counts),
        "specimens": study.stiffness_n_per_mm,
        "hypotheses.use": study.hypotheses.use,
        "window.force_n": Keyed(study.window, study.window.force_n),
    }


def emulation_settings(campaign: Campaign, item: str) -> dict[str, Any]:
    """Settings of one run. Of the other runs they hold only the place of this run among them."""
    assert campaign.rig is not None
    run = campaign.mountings[item]
    experiment, emulated, placeless = campaign.emulations[run.specimen]
    changed = _changed_guards()
    return (
        {
            "run": run,
            "order": campaign.places[item],
            "experiment": experiment,
            "rig": campaign.rig.rig,
            # where tables lie is no part of the key: they are files
            "emulated": Keyed(emulated, placeless) if emulated.domes else emulated,
        }
        | ({"changed_guards": changed} if changed else {})
        | _other_actuator(campaign.rig.devices.actuator)
    )


def own_domes(campaign: Campaign, item: str) -> dict[str, Sequence[Path]]:
    """A sensor's own tables of domes."""
    source = campaign.study.runs_source
    return {"domes": sorted(source.domes.glob("*.npz"))} if source and source.domes else {}


def emulated_domes(campaign: Campaign, item: str) -> dict[str, Sequence[Path]]:
    """Tables of the emulated dome."""
    domes = campaign.rig and campaign.rig.emulated and campaign.rig.emulated.domes
    return {"emulated domes": sorted(Path(domes).glob("*.npz"))} if domes else {}


def _other_actuator(settings: ActuatorSettings) -> dict[str, Any]:
    """Settings of an actuator that [emulated] does not describe; addresses are left out."""
    return {} if settings.kind == "qbmove" else {"actuator": replace(settings, port=None, serial_number=None)}


def _changed_guards() -> tuple[str, ...]:
    """Guards that differ from those of this program. A process that has not loaded the guards has changed none."""
    guards = sys.modules.get("emg2vsa.rig.executor.guards")
    return guards.changed_guards() if guards else ()
