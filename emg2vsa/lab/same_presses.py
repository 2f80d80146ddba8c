"""Presses of one run that are made in several sessions, perhaps with a rig file that has changed in between."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from emg2vsa.errors import DataError
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.record.new_folder import EMULATED_FILE, PLAN_FILE, folders_of, good_presses
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.schedules.document import document_of

_PLAN_KEYS = ("f_max_n", "f_contact_n", "contact_s", "ramp_mm_per_s", "travel_mm", "lead_s")
_RIG_KEYS = ("gear_mm_per_degree", "push_sign", "push_axis", "filter_samples")
_TOLD = ("force_to_n", "activity_v", "stiffness_percent", "stiffness_nm_per_rad")
"""Of a step; what is left says when it begins, and what the actuator is sent."""


def check_same_presses(runs: Path, name: str, plan: RunPlan, rig: RigSettings, *, emulated: bool) -> None:
    """Presses that are scored together are made in the same way.

    DataError : a folder of run ``name`` that has presses, made by a rig of the same kind, was pressed with another
    force, speed, schedule, gear, direction or filter than ``plan`` and ``rig`` now say; what its plan.json does not
    tell, as that of version 0.1.0, is not compared.
    """
    schedule = None if plan.schedule is None else document_of(plan.schedule)
    now = _made_with({"plan": asdict(replace(plan, schedule=None)) | {"schedule": schedule}, "rig": asdict(rig)})
    for folder in folders_of(runs, name):
        if not folder.exists():
            return
        if (folder / EMULATED_FILE).is_file() != emulated or not good_presses(folder):
            continue
        for key, before in _pressed_with(folder / PLAN_FILE).items():
            if key in now and before != (today := now[key]):
                do = "Take the earlier setting again, or move the folder away and begin anew, or choose another --out."
                wanted = f"{key} = {_brief(today)}, as the rig file and its schedules say now"
                raise DataError(folder / PLAN_FILE, wanted=wanted, found=_brief(before), do=do)


def _made_with(document: Mapping[str, Any]) -> dict[str, Any]:
    plan, rig = document["plan"], document["rig"]
    made = {key: plan[key] for key in _PLAN_KEYS if key in plan} | {key: rig[key] for key in _RIG_KEYS if key in rig}
    schedule = plan.get("schedule") or {}
    if "actuator" in (limits := schedule.get("limits", {})):
        made["actuator of the schedule"] = limits["actuator"]
    if steps := schedule.get("steps"):
        made |= {f"{key} of the schedule": [step[key] for step in steps] for key in steps[0] if key not in _TOLD}
    return {key: list(value) if isinstance(value, tuple) else value for key, value in made.items()}


def _pressed_with(path: Path) -> dict[str, Any]:
    """What a plan.json says of how it was pressed; nothing where it cannot be read."""
    try:
        return _made_with(json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return {}


def _brief(value: object) -> str:
    text = json.dumps(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
