"""One run on the devices of the rig file."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path

from emg2vsa.atomic import write_text_atomic
from emg2vsa.cli.rig.ending import told
from emg2vsa.cli.rig.press_lines import PressLines
from emg2vsa.errors import DeviceError, SettingError
from emg2vsa.rig.clock import WallClock
from emg2vsa.rig.execute import execute
from emg2vsa.rig.experiment import run_name
from emg2vsa.rig.moving_average import MovingAverage
from emg2vsa.rig.new_folder import completed_folder, how_ended, new_folder, presses_done
from emg2vsa.rig.open_rig import OpenRig, open_rig
from emg2vsa.rig.plan import RIGID, RunPlan
from emg2vsa.rig.plan_limits import check_plan
from emg2vsa.rig.run_record import EMULATED_FILE
from emg2vsa.rig.stop_requests import StopRequests
from emg2vsa.rig.undisturbed import undisturbed
from emg2vsa.rig_file import RigFile
from emg2vsa.rig_file.plans import Run, plans_of


def run_for_real(file: RigFile, runs: Sequence[Run], root: Path, repetitions: int | None) -> int:
    """The one run of ``runs``; exit status. Lists what is to do, and raises SettingError, where it is not one."""
    if len(runs) != 1:
        raise _not_one(file, runs, root)
    (plan,) = plans_of(file, runs, repetitions)
    check_plan(plan, file.rig)
    folder = new_folder(root, run_name(*runs[0]), file.experiment.repetitions)
    clock, started = WallClock(), datetime.now(UTC)
    ended = None
    try:
        with (
            undisturbed(),
            StopRequests(folder) as stop,
            open_rig(file.devices, file.rig, plan.condition, clock) as opened,
        ):
            check_plan(plan, opened.rig)
            _mark_emulated(file, folder)
            _introduce(folder, plan, opened, file.devices.force.bias)
            with PressLines(folder, plan.repetitions):
                ended = execute(plan, opened.rig, opened.devices, folder, clock, started=started, stop=stop)
            print(told(ended, plan.repetitions, folder, opened.rig))
    except DeviceError as error:
        if ended is None:
            raise
        # the run is on disk; what failed is the way a device was left
        print(f"emg2vsa: {error}", file=sys.stderr)
        return 1
    return int(ended.how != "completed")


def _mark_emulated(file: RigFile, folder: Path) -> None:
    """No run of emulated devices ever passes as a measured one."""
    if file.emulated is not None and file.emulated.behind_ports:
        folder.mkdir(parents=True, exist_ok=True)
        write_text_atomic(folder / EMULATED_FILE, json.dumps(asdict(file.emulated), indent=2) + "\n")


def _introduce(folder: Path, plan: RunPlan, opened: OpenRig, biased: bool) -> None:
    rig = opened.rig
    low, high = rig.position_ticks
    print(f"folder: {folder}")
    print(f"run: {plan.specimen}, {plan.angle_deg:g} degrees, {plan.condition}, {plan.repetitions} presses")
    stiffness = "rigid" if plan.condition == RIGID else f"full stiffness {rig.max_preset_ticks} ticks"
    print(f"device: {opened.info.firmware}, positions {low} to {high} ticks, {stiffness}")
    print(f"force: {MovingAverage(rig.filter_samples, rig.rate_hz).description}")
    if biased:
        print("force: the load at this moment is now its zero")
    sys.stdout.flush()


def _not_one(file: RigFile, runs: Sequence[Run], root: Path) -> SettingError:
    presses = file.experiment.repetitions
    left = [run for run in runs if completed_folder(root, run_name(*run), presses) is None]
    for specimen, angle_deg, condition in left:
        before = root / run_name(specimen, angle_deg, condition)
        how = how_ended(before)
        note = f"   # {how} before, {presses_done(before)} of {presses} presses" if how else ""
        print(f"--specimen {specimen} --angle {angle_deg:g} --condition {condition}{note}")
    return SettingError(
        file.path,
        wanted="one run",
        found=f"{len(runs)}, of which {len(left)} are still to do",
        do="Name one as listed, or add --virtual to emulate them all.",
    )
