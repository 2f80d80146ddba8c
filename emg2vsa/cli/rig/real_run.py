"""One run on the devices of the rig file."""

from __future__ import annotations

import contextlib
import json
import sys
import threading
from collections.abc import Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Self

from casr.atomic import write_text_atomic
from emg2vsa.cli.rig.ending import told
from emg2vsa.errors import DeviceError, SettingError
from emg2vsa.rig.clock import WallClock, undisturbed
from emg2vsa.rig.executor.execute import execute
from emg2vsa.rig.executor.plan_limits import check_plan
from emg2vsa.rig.executor.stop_requests import StopRequests
from emg2vsa.rig.experiment import run_name
from emg2vsa.rig.force.moving_average import MovingAverage
from emg2vsa.rig.open_rig import OpenRig, open_rig
from emg2vsa.rig.plan import RIGID, RunPlan
from emg2vsa.rig.record.new_folder import EMULATED_FILE, completed_folder, how_ended, new_folder, presses_done
from emg2vsa.rig_file import RigFile
from emg2vsa.rig_file.plans import Run, plans_of
from emg2vsa.run_folders.find import left_by_emulator

_LOOK_S = 0.2
_TAIL_BYTES = 512


def run_for_real(file: RigFile, runs: Sequence[Run], root: Path, repetitions: int | None) -> int:
    """The one run of ``runs``; exit status. Lists what is to do, and raises SettingError, where it is not one."""
    if root == file.runs and not file.leads_to_emulated:
        _tell_left(file)
    if len(runs) != 1:
        raise _not_one(file, runs, root)
    (plan,) = plans_of(file, runs, repetitions)
    check_plan(plan, file.rig)
    folder = new_folder(root, run_name(*runs[0]), file.experiment.repetitions, emulated=file.leads_to_emulated)
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
                ended = execute(
                    plan, opened.rig, opened.devices, folder, clock,
                    started=started, stop=stop, facts=opened.facts, background=True,
                )  # fmt: skip
            print(told(ended, plan.repetitions, folder, opened.rig))
    except DeviceError as error:
        if ended is None:
            raise
        # the run is on disk; what failed is the way a device was left
        print(f"emg2vsa: {error}", file=sys.stderr)
        return 1
    return int(ended.how != "completed")


def _tell_left(file: RigFile) -> None:
    if left := left_by_emulator(file.runs):
        print(
            f"emg2vsa: {len(left)} folders in {file.runs} were made by the emulated rig of version 0.1.0 and do not "
            f"count as done; emg2vsa clean STUDY --move-virtual moves them away.",
            file=sys.stderr,
        )


def _mark_emulated(file: RigFile, folder: Path) -> None:
    """No run of emulated devices ever passes as a measured one."""
    if file.emulated and file.leads_to_emulated:
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
    emulated = file.leads_to_emulated
    left = [run for run in runs if completed_folder(root, run_name(*run), presses, emulated=emulated) is None]
    for specimen, angle_deg, condition in left:
        before = root / run_name(specimen, angle_deg, condition)
        how = how_ended(before)
        note = f"   # {how} before, {presses_done(before)} of {presses} presses" if how else ""
        print(f"--specimen {specimen} --angle {angle_deg:g} --condition {condition}{note}")
    return SettingError(
        file.path,
        wanted="one run",
        found=f"{len(runs)}, of which {len(left)} are still to do",
        do="Name one as listed, or add --virtual to emulate them all."
        if left
        else "To repeat one, move its folder away, or choose another folder with --out.",
    )


class PressLines:
    """Says on the error stream which presses are over, from `__enter__` to `__exit__`.

    It reads the log, so that no terminal can hold up the control loop.
    """

    def __init__(self, folder: Path, repetitions: int) -> None:
        self._log, self._repetitions, self._said = folder / "log.csv", repetitions, 0
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._ended.set()
        self._thread.join()

    def _watch(self) -> None:
        # no log yet, or nobody who reads: the run goes on all the same
        while not self._ended.wait(_LOOK_S):
            with contextlib.suppress(OSError, IndexError):
                self._look()

    def _look(self) -> None:
        with self._log.open("rb") as log:
            log.seek(max(0, self._log.stat().st_size - _TAIL_BYTES))
            lines = log.read().decode("ascii").split("\n")
        time_s, repetition, phase = lines[-2].split(",")[:3]  # what follows the last line end is no whole row
        if repetition == "repetition":
            return
        done = int(repetition) - (phase not in ("pause", "done"))
        for press in range(self._said + 1, done + 1):
            print(f"press {press} of {self._repetitions} done at {float(time_s):.1f} s", file=sys.stderr, flush=True)
        self._said = max(self._said, done)
