"""What the page says of a run that does not change while it runs."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from emg2vsa.errors import RecordingError
from emg2vsa.rig.rig_settings import RigSettings

PLAN_FILE = "plan.json"


@dataclass(frozen=True)
class RunFacts:
    """From plan.json."""

    name: str
    "Of its folder."
    specimen: str
    angle_deg: float
    condition: str
    repetitions: int
    f_contact_n: float
    f_max_n: float
    force_limit_n: float
    "Of the guard."
    travel_mm: float
    max_preset_ticks: int
    stiffness_percent: tuple[float, float]
    "The study's range, percent of the maximum preset."
    emulated: bool
    "No hardware takes part."


def read_run(folder: Path) -> tuple[RunFacts, RigSettings]:
    """The run in ``folder``, and its rig as far as depth needs it. RecordingError without a whole plan.json."""
    path = folder / PLAN_FILE
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        plan, rig = document["plan"], document["rig"]
        axis = RigSettings(
            gear_mm_per_degree=rig["gear_mm_per_degree"], home_ticks=rig["home_ticks"], push_sign=rig["push_sign"]
        )
        low, high = rig["stiffness_percent"]
        facts = RunFacts(
            name=folder.name,
            **{name: plan[name] for name in ("specimen", "angle_deg", "condition", "repetitions")},
            **{name: plan[name] for name in ("f_contact_n", "f_max_n", "travel_mm")},
            force_limit_n=rig["guards"]["force_n"],
            max_preset_ticks=rig["max_preset_ticks"],
            stiffness_percent=(low, high),
            emulated=(folder / "emulated.json").is_file(),
        )
    except (OSError, ValueError, TypeError, KeyError) as error:
        found, do = f"{type(error).__name__}: {error}", "Choose the folder of a run, or of runs."
        raise RecordingError(path, wanted="the plan of a run", found=found, do=do) from error
    return facts, axis
