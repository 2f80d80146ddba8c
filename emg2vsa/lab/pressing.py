"""What all ways of running presses share: plans that were checked, presses that are missing, and one run pressed."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from emg2vsa.errors import DataError, Emg2vsaError, InputError, SettingError
from emg2vsa.lab.judging import WHOLE_PRESSES, Judging
from emg2vsa.lab.person import NOBODY, Person
from emg2vsa.lab.pressed import Pressed
from emg2vsa.lab.real_press import press_for_real, with_reference
from emg2vsa.process_pool import ProcessPool, WorkerDied
from emg2vsa.rig.executor.guards import changed_guards
from emg2vsa.rig.executor.plan_limits import DryRun, check_plan, is_count
from emg2vsa.rig.executor.plan_limits import dry_run as tried
from emg2vsa.rig.experiment import run_name
from emg2vsa.rig.kappa.live_kappa import KappaPlan
from emg2vsa.rig.plan import Condition, RunPlan
from emg2vsa.rig.record.ended import Ended
from emg2vsa.rig.record.new_folder import EMULATED_FILE, PLAN_FILE, folders_of, good_presses, new_folder, presses_left
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.rig_file import RigFile, load_rig
from emg2vsa.rig_file.plans import Run, chosen_runs, ordered, plans_of, read_schedules
from emg2vsa.schedules.document import document_of
from emg2vsa.study_file.problems import shown
from emg2vsa.worlds.bench.controls import ArtificialEffect, effect_of
from emg2vsa.worlds.bench.settings import EmulatedSettings
from emg2vsa.worlds.bench.virtual_run import run_virtual

load = load_rig


@dataclass(frozen=True)
class VirtualJob:
    """All that a process needs to carry out one run."""

    plan: RunPlan
    rig: RigSettings
    emulated: EmulatedSettings
    folder: Path
    effect: ArtificialEffect | None = None
    kappa: KappaPlan | None = None
    actuator: Any = None

    def __call__(self) -> Ended:
        """Raises as `run_virtual`."""
        plan, started, run, mounted = self.plan, datetime.now(UTC), self.folder.name, ""
        if plan.plate:
            run = f"{run}, plate"
        else:
            mounted = run_name(plan.specimen, plan.angle_deg, plan.condition, plan.mounting)
        return run_virtual(
            plan, self.rig, self.emulated, self.folder,
            started=started, run=run, mounted=mounted, effect=self.effect, kappa=self.kappa,
            actuator=self.actuator,
        )  # fmt: skip


def virtual_job(file: RigFile, plan: RunPlan, folder: Path, kappa: KappaPlan | None = None) -> VirtualJob:
    """``plan`` on the emulated rig, to be recorded in ``folder``. SettingError : the rig file has none."""
    emulated = emulated_of(file)
    named = None if plan.plate else emulated.control_specimen
    # what the noise of control P4 is matched to
    right = read_schedules(file, [Run(named, 0.0, "modular")], {}) if named else ()
    effect = None if plan.plate else effect_of(emulated, plan.schedule, right)
    return VirtualJob(plan, file.rig, emulated, folder, effect, kappa, file.devices.actuator)


def emulated_of(file: RigFile) -> EmulatedSettings:
    """The table [emulated]. SettingError where there is none."""
    if file.emulated is None:
        do = "Add it (docs/reference/rig-file.md), or leave out --virtual."
        raise SettingError(file.path, wanted="a table [emulated]", found="none", do=do)
    return file.emulated


def carried_out(waiting: Mapping[Run, VirtualJob], jobs: int) -> Iterator[tuple[Run, Ended | str]]:
    """Every run and how it ended, or why there is none, in the order of their ends.

    jobs : processes to use; only this one where the program has changed the guards, of which no other knows."""
    runs, calls = list(waiting), list(waiting.values())
    with ProcessPool(1 if changed_guards() else min(jobs, len(calls))) as pool:
        for i, result in pool.ended(calls, load=[__name__]):
            yield runs[i], _outcome(result)


def _outcome(make: Callable[[], Ended]) -> Ended | str:
    try:
        return make()
    except Emg2vsaError as error:
        return f"not run. {error}"
    except WorkerDied as error:
        return f"not run: {error}"


UNSAFE = (
    "The sequence ends here: {folder} was left with the probe NOT retracted, or motors NOT confirmed off. Switch off "
    "with emg2vsa rig off {rig}, take the probe away with emg2vsa rig home {rig}, and look at ended.json before you "
    "give the same command again."
)
"""Message of a run that ends a sequence."""


@dataclass(frozen=True)
class Pressing:
    """Where presses are made and kept.

    root : folder of the runs. virtual : on the emulated rig in virtual time, else on the devices of the rig file.
    """

    file: RigFile
    root: Path
    virtual: bool = False
    person: Person = NOBODY

    @property
    def emulated(self) -> bool:
        """No hardware makes these presses."""
        return self.virtual or self.file.leads_to_emulated

    def plans(self, runs: Sequence[Run], presses: int | None = None) -> dict[Run, RunPlan]:
        """The plan of each run, within the limits of the rig file. presses : instead of the experiment's.

        SettingError : a plan breaks a limit, or there is no emulated rig. ScheduleError : as `plans_of`.
        """
        if self.virtual:
            emulated_of(self.file)
        plans = dict(zip(runs, map(self.witnessed, plans_of(self.file, runs, presses)), strict=True))
        for plan in plans.values():
            check_plan(plan, self.file.rig)
        return plans

    def witnessed(self, plan: RunPlan) -> RunPlan:
        """With the current of a rigid motor, by a reference that holds still."""
        return with_reference(self.file, plan, virtual=self.virtual)

    def check_same(self, name: str, plan: RunPlan) -> None:
        """DataError where earlier presses of the run ``name`` were made in another way."""
        check_same_presses(self.root, name, plan, self.file.rig, emulated=self.emulated)

    def missing(self, name: str, presses: int | None = None) -> int:
        """Presses that the run ``name`` lacks of so many, else of those of the experiment."""
        whole = presses or self.file.experiment.repetitions
        return presses_left(self.root, name, whole, emulated=self.emulated)

    def folder(self, name: str, presses: int | None = None) -> Path:
        """New folder for the run ``name``. DataError where it has all its presses."""
        whole = presses or self.file.experiment.repetitions
        return new_folder(self.root, name, whole, emulated=self.emulated)

    def press(self, plan: RunPlan, folder: Path, kappa: KappaPlan | None = None) -> Pressed:
        """Carry out ``plan``, recorded in ``folder``. Raises as `press_for_real` or `run_virtual`."""
        if self.virtual:
            return Pressed(folder, virtual_job(self.file, plan, folder, kappa)())
        return Pressed(folder, press_for_real(self.file, plan, folder, self.person, kappa))

    def warn_unless_safe(self, pressed: Pressed) -> None:
        """The person must know where a run left the probe on the specimen, or the motors on."""
        if not pressed.left_safe:
            self.person.warn(UNSAFE.format(folder=pressed.folder, rig=self.file.path))


def press(
    file: RigFile, specimen: str, angle_deg: float = 0.0, condition: Condition = "modular", mounting: int = 1, *,
    presses: int | None = None, folder: str | Path | None = None, virtual: bool = False,
    judging: Judging = WHOLE_PRESSES, person: Person = NOBODY,
) -> Pressed:  # fmt: skip
    """Press one specimen at one angle, degrees, under one condition of stiffness; where it is recorded, and its log.

    Parameters
    ----------
    specimen, angle_deg, condition, mounting : a run of the experiment of ``file``.
    presses : None: those that the run still lacks.
    folder : of the runs, in which this one gets a folder of its own; None: that of the rig file.
    virtual : on the emulated rig, faster than real time; else the devices of the rig file press, in real time.
    judging : calibrations that tell the stiffness of the specimen while it is pressed.
    person : who is told what goes on.

    Raises
    ------
    SettingError, ScheduleError, DataError : no such run, a limit of the rig that it breaks, a schedule that is absent,
    or a run that is done; nothing has moved. DeviceError : a device is absent, or another process uses the rig.

    Examples
    --------
    >>> run = rig.press(rig.load("rig.toml"), "S3", 0, "modular", virtual=True)
    >>> run.log.plot("depth_mm", "force_n")
    """
    pressing = pressing_of(file, folder, virtual, person, presses=presses)
    (run,) = chosen_runs(file, [specimen], [angle_deg], [condition], [mounting])
    plans = pressing.plans((run,), presses or pressing.missing(run.name) or file.experiment.repetitions)
    pressing.check_same(run.name, plans[run])
    kappa = judging.plans(file, plans, emulated=pressing.emulated)[run]
    return pressing.press(plans[run], pressing.folder(run.name), kappa)


def pressing_of(
    file: RigFile, folder: str | Path | None, virtual: bool, person: Person, **counts: int | None
) -> Pressing:
    """As `press` has them. SettingError : one of ``counts`` is no whole number from 1, nor None."""
    for name, count in counts.items():
        if count is not None and not is_count(count):
            raise SettingError(name, wanted="a whole number from 1", found=repr(count), do=f"Choose other {name}.")
    usual = file.virtual_runs if virtual else file.runs
    return Pressing(file, usual if folder is None else Path(folder), virtual, person)


_PLAN_KEYS = ("f_max_n", "f_contact_n", "contact_s", "ramp_mm_per_s", "travel_mm", "lead_s")
_RIG_KEYS = ("gear_mm_per_degree", "push_sign", "push_axis", "filter_samples")
_TOLD = (
    "force_to_n", "activity_v", "stiffness_percent", "stiffness_low_percent", "stiffness_high_percent",
    "stiffness_nm_per_rad",
)  # fmt: skip
"""Columns of a step that only inform; the others say when it begins, and what the actuator is sent."""


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
                wanted = f"{key} = {shown(today)}, as the rig file and its schedules say now"
                raise DataError(folder / PLAN_FILE, wanted=wanted, found=shown(before), do=do)


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


def dry_run(file: RigFile, runs: Sequence[Run] = ()) -> dict[Run, DryRun | str]:
    """What each run would send, or why it is not possible, in the order of the experiment. No device is opened.

    runs : none: all of the experiment. ScheduleError : a schedule is absent, or for another actuator.
    """
    runs = runs or file.experiment.all_runs()
    plans = {run: with_reference(file, plan) for run, plan in zip(runs, plans_of(file, runs), strict=True)}
    told: dict[Run, DryRun | str] = {}
    for run in ordered(file.experiment).runs:
        if run in plans:
            try:
                told[run] = tried(plans[run], file.rig)
            except InputError as error:
                told[run] = str(error)
    return told


def limits(file: RigFile) -> dict[str, str]:
    """Limits of the rig file, in words."""
    rig = file.rig
    way_deg = rig.position_at(rig.travel_mm) - rig.home_deg
    return {
        "positions": "{:.6g} to {:.6g} degrees".format(*rig.position_deg),
        "presets": "{:g} to {:g} % of the full one".format(*rig.stiffness_percent),
        "travel": f"{rig.travel_mm:g} mm, {way_deg:+.6g} degrees from home",
        "force": f"{rig.guards.force_n:g} N, {rig.guards.force_rate_n_per_s:g} N/s",
    }
