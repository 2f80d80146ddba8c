"""Any number of runs on the emulated rig, side by side, in virtual time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from emg2vsa.errors import Emg2vsaError, SettingError
from emg2vsa.process_pool import ProcessPool, WorkerDied
from emg2vsa.rig.executor.guards import changed_guards
from emg2vsa.rig.experiment import run_name
from emg2vsa.rig.kappa.live_kappa import KappaPlan
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.record.ended import Ended
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.rig_file import RigFile
from emg2vsa.rig_file.plans import Run, read_schedules
from emg2vsa.worlds.bench.controls import ArtificialEffect, effect_of
from emg2vsa.worlds.bench.settings import EmulatedSettings
from emg2vsa.worlds.bench.virtual_run import run_virtual


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
    right = read_schedules(file.schedules, [Run(named, 0.0, "modular")], {}) if named else ()
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
