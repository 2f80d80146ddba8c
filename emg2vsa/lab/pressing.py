"""What all ways of running presses share: plans that were checked, presses that are missing, and one run pressed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from emg2vsa.lab.judging import Judging
from emg2vsa.lab.person import NOBODY, Person
from emg2vsa.lab.pressed import Pressed
from emg2vsa.lab.real_press import press_for_real
from emg2vsa.lab.same_presses import check_same_presses
from emg2vsa.lab.virtual_runs import emulated_of, virtual_job
from emg2vsa.rig.executor.plan_limits import check_plan
from emg2vsa.rig.kappa.live_kappa import KappaPlan
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.record.new_folder import new_folder, presses_left
from emg2vsa.rig_file import RigFile
from emg2vsa.rig_file.plans import Run, plans_of

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

    def press_run(self, run: Run, judging: Judging, presses: int | None = None) -> Pressed:
        """One run in a new folder: ``presses``, else those that it still lacks, else those of the experiment.

        Raises as `plans`, `check_same`, `Judging.plans`, `folder` and `press`; what is no DeviceError comes before
        anything has moved.
        """
        plans = self.plans((run,), presses or self.missing(run.name) or self.file.experiment.repetitions)
        self.check_same(run.name, plans[run])
        kappa = judging.plans(self.file, plans, emulated=self.emulated)[run]
        return self.press(plans[run], self.folder(run.name), kappa)
