"""What the page says of a run: what does not change while it runs, and how it ended."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from emg2vsa.devices.joints import joint_of
from emg2vsa.devices.qbmove.ticks import in_degrees
from emg2vsa.errors import RecordingError, ScheduleError
from emg2vsa.rig.record.new_folder import EMULATED_FILE, PLAN_FILE, over_bytes
from emg2vsa.rig.rig_settings import RigSettings, axis_of


@dataclass(frozen=True)
class RunFacts:
    """Facts of a run from plan.json."""

    name: str
    "Name of its folder."
    specimen: str
    angle_deg: float
    condition: str
    repetitions: int
    f_contact_n: float
    f_max_n: float
    force_limit_n: float
    "Limit of the guard."
    travel_mm: float
    full_preset: float
    "Full preset in the unit of the log's rows: springs degrees, a gain N m/rad."
    stiffness_nm_per_rad: tuple[float, ...]
    "At zero load, of presets of 0, 1, ... 100 % of the full one; none under the rigid motor."
    stiffness_percent: tuple[float, float]
    "The study's range, percent of the maximum preset."
    emulated: bool
    "No hardware takes part."
    over_bytes: bool
    "Whether the drivers speak as those of hardware do; False where those of an emulated rig skip the wire."


def read_run(folder: Path) -> tuple[RunFacts, RigSettings]:
    """The run in ``folder``, and its rig as far as depth needs it. RecordingError without a whole plan.json."""
    path = folder / PLAN_FILE
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        plan, rig = document["plan"], document["rig"]
        axis = axis_of(rig)
        low, high = rig["stiffness_percent"]
        facts = RunFacts(
            name=folder.name,
            **{name: plan[name] for name in ("specimen", "angle_deg", "condition", "repetitions")},
            **{name: plan[name] for name in ("f_contact_n", "f_max_n", "travel_mm")},
            force_limit_n=rig["guards"]["force_n"],
            full_preset=in_degrees(rig)["full_preset"],
            stiffness_nm_per_rad=_stiffness(plan["schedule"], in_degrees(rig)["full_preset"]),
            stiffness_percent=(low, high),
            emulated=(folder / EMULATED_FILE).is_file(),
            over_bytes=over_bytes(folder),
        )
    except (OSError, ValueError, TypeError, KeyError, ScheduleError) as error:
        found, do = f"{type(error).__name__}: {error}", "Choose the folder of a run, or of runs."
        raise RecordingError(path, wanted="the plan of a run", found=found, do=do) from error
    return facts, axis


def _stiffness(schedule: Mapping[str, Any] | None, full_preset: float) -> tuple[float, ...]:
    if schedule is None:
        return ()
    joint = joint_of(schedule["limits"]["actuator"], full_preset)
    return tuple(joint.stiffness_nm_per_rad([percent / 100 for percent in range(101)]).round(5).tolist())


_HOW = {
    "completed": "Completed", "stopped": "Stopped", "interrupted": "Interrupted",
    "guard": "Ended by a guard", "failed": "Ended by an error of the program",
}  # fmt: skip


@dataclass(frozen=True)
class Ending:
    """How a run ended, in words for those who stand beside it."""

    kind: Literal["good", "stopped", "guard", "danger"]
    "Danger: nobody knows that the rig is safe."
    title: str
    text: str
    presses_done: int


def read_ending(folder: Path, repetitions: int) -> Ending | None:
    """How the run in ``folder`` ended, after how many of ``repetitions`` presses; None as long as nothing says so.

    ended.json says "killed" from the start, and "killed" is never told from "still running" by the file alone.
    """
    try:
        said = json.loads((folder / "ended.json").read_text(encoding="utf-8"))
        return None if said["how"] == "killed" else _ending(said, repetitions)
    except (OSError, ValueError, TypeError, KeyError):  # not there yet, or being replaced
        return None


def _ending(said: dict[str, Any], repetitions: int) -> Ending:
    how = said["how"]
    title = _HOW[how] + (f": {said['cause']}" if said["cause"] else "")
    done = f"{said['repetitions_done']} of {repetitions} presses done"
    where = "" if how == "completed" else f", ended in phase {said['phase']}"
    why = "" if how == "stopped" else said["why"]  # the cause says it all
    sentences = [f"{done}{where}", why, *_safety(said), *said["notes"]]
    safe = said["retracted"] and said["deactivated"]
    kind: Any = "danger" if not safe else {"completed": "good", "stopped": "stopped"}.get(how, "guard")
    text = " ".join(f"{text[0].upper()}{text[1:].rstrip('.')}." for text in sentences if text)
    return Ending(kind, title, text, said["repetitions_done"])


def _safety(said: dict[str, Any]) -> tuple[str, str]:
    return (
        "Probe retracted" if said["retracted"] else "Probe NOT known to be retracted",
        "Motors off" if said["deactivated"] else "Motors NOT known to be off: cut their power",
    )
