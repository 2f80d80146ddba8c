"""What all ways of running presses share: plans that were checked, presses that are missing, and one run pressed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from emg2vsa.errors import SettingError
from emg2vsa.lab.judging import WHOLE_PRESSES, Judging
from emg2vsa.lab.person import NOBODY, Person
from emg2vsa.lab.pressed import Pressed
from emg2vsa.lab.real_press import press_for_real
from emg2vsa.lab.same_presses import check_same_presses
from emg2vsa.lab.virtual_runs import emulated_of, virtual_job
from emg2vsa.rig.executor.plan_limits import check_plan, is_count
from emg2vsa.rig.kappa.live_kappa import KappaPlan
from emg2vsa.rig.plan import Condition, RunPlan
from emg2vsa.rig.record.new_folder import new_folder, presses_left
from emg2vsa.rig_file import RigFile, load_rig
from emg2vsa.rig_file.plans import Run, chosen_runs, plans_of

load = load_rig
UNSAFE = (
    "The sequence ends here: {folder} was left with the probe NOT retracted, or motors NOT confirmed off. Switch off "
    "with emg2vsa rig off {rig}, take the probe away with emg2vsa rig home {rig}, and look at ended.json before you "
    "give the same command again."
)
"""Of a run among others, which end with it."""


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
        plans = dict(zip(runs, plans_of(self.file, runs, presses), strict=True))
        for plan in plans.values():
            check_plan(plan, self.file.rig)
        return plans

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
