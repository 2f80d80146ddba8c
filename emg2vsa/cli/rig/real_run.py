"""Runs on the devices of the rig file, one at a time."""

from __future__ import annotations

import contextlib
import json
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Self

from casr.atomic import write_text_atomic
from casr.command_line import print_json
from casr.frame_files import write_camera
from casr.frame_files.folder import CAMERA_FILE
from casr.terminal import note
from emg2vsa.cli.rig.ending import told
from emg2vsa.cli.rig.kappa_options import KappaPlans, say_kappa, say_reachable
from emg2vsa.cli.rig.prove_watchdog import remark
from emg2vsa.cli.rig.rig_lock import rig_lock
from emg2vsa.cli.rig.same_presses import check_same_presses
from emg2vsa.errors import DeviceError, SettingError
from emg2vsa.rig.clock import Clock, WallClock, undisturbed
from emg2vsa.rig.commissioning.watchdog import read_proofs
from emg2vsa.rig.executor.execute import execute
from emg2vsa.rig.executor.guards import laxer_guards
from emg2vsa.rig.executor.plan_limits import check_plan
from emg2vsa.rig.executor.stop_requests import StopRequests
from emg2vsa.rig.force.moving_average import MovingAverage
from emg2vsa.rig.kappa.judges import write_about
from emg2vsa.rig.kappa.live_kappa import KAPPA_FILE, KappaPlan
from emg2vsa.rig.kappa.own_process import OwnProcess
from emg2vsa.rig.open_rig import OpenRig, board_settings, open_rig
from emg2vsa.rig.plan import RIGID, Condition, RunPlan
from emg2vsa.rig.record.ended import Ended
from emg2vsa.rig.record.new_folder import EMULATED_FILE, how_ended, new_folder, presses_left
from emg2vsa.rig_file import RigFile
from emg2vsa.rig_file.plans import Run, plans_of
from emg2vsa.run_folders.find import left_by_emulator

_LOOK_S = 0.2
_TAIL_BYTES = 512


def run_for_real(
    file: RigFile, runs: Sequence[Run], root: Path, repetitions: int | None, *, kappa: KappaPlans, as_json: bool
) -> int:
    """The one run of ``runs``, as many presses as it still lacks; more than one are listed. Exit status."""
    if root == file.runs and not file.leads_to_emulated:
        _tell_left(file)
    if len(runs) != 1:
        _list(file, runs, root, as_json=as_json)
        return 0
    presses = repetitions or missing(file, runs[0], root) or file.experiment.repetitions
    (plan,) = plans_of(file, runs, presses)
    check_plan(plan, file.rig)
    check_same_presses(root, runs[0].name, plan, file.rig, emulated=file.leads_to_emulated)
    judged = kappa({runs[0]: plan})[runs[0]]
    folder, ended = press_run(file, runs[0], plan, root, kappa=judged, quiet=as_json)
    if as_json:
        print_json({"folder": str(folder), "ended": asdict(ended)})
    return int(ended.how != "completed")


def missing(file: RigFile, run: Run, root: Path) -> int:
    """Presses that a run of the experiment still lacks."""
    presses, emulated = file.experiment.repetitions, file.leads_to_emulated
    return presses_left(root, run.name, presses, emulated=emulated)


def press_run(
    file: RigFile, run: Run, plan: RunPlan, root: Path, *, kappa: KappaPlan | None = None, quiet: bool = False
) -> tuple[Path, Ended]:
    """Carry out ``plan`` on the devices of the rig file, in a new folder; it, and how the run ended. ``kappa`` : judge
    each press while it goes on.

    Raises as `open_rig` and `execute`, and DataError where the run has all its presses: nothing has moved then.
    """
    folder = new_folder(root, run.name, file.experiment.repetitions, emulated=file.leads_to_emulated)
    return folder, press_plan(file, plan, folder, kappa=kappa, quiet=quiet)


def press_plan(
    file: RigFile, plan: RunPlan, folder: Path, *, kappa: KappaPlan | None = None, quiet: bool = False
) -> Ended:
    """Carry out ``plan`` on the devices of the rig file, recorded in ``folder``. Raises as `open_rig` and `execute`."""
    clock, started = WallClock(), datetime.now(UTC)
    ended = None
    try:
        with (
            rig_lock(file.path, folder),
            _judge(file, kappa, plan, folder, clock, quiet=quiet) as judge,
            undisturbed(),
            StopRequests(folder) as stop,
            open_rig(file.devices, file.rig, plan.condition, clock) as opened,
        ):
            check_plan(plan, opened.rig)
            _mark_emulated(file, folder)
            watchdog, proof = _watchdog(file, plan.condition, opened)
            if not quiet:
                _introduce(folder, plan, opened, file.devices.force.bias, watchdog)
            with PressLines(folder, plan.repetitions):
                ended = execute(
                    plan, opened.rig, opened.devices, folder, clock,
                    started=started, stop=stop, facts=opened.facts | {"watchdog": proof}, background=True,
                    judge=judge,
                )  # fmt: skip
            if not quiet:
                print(told(ended, plan.repetitions, folder, opened.rig))
        if kappa is not None and not quiet:
            say_kappa(folder)
    except DeviceError as error:
        if ended is None:
            raise
        # the run is on disk; what failed is the way a device was left
        print(f"emg2vsa: {error}", file=sys.stderr)
        ended = replace(ended, how="failed", cause="device", why=str(error))
    return ended


@contextlib.contextmanager
def _judge(
    file: RigFile, kappa: KappaPlan | None, plan: RunPlan, folder: Path, clock: Clock, *, quiet: bool
) -> Iterator[OwnProcess | None]:
    """A process that judges the presses, and what it was shown in kappa.json; None where nobody asked for it."""
    if kappa is None:
        yield None
        return
    if file.devices.camera is None:
        raise SettingError(
            file.path, wanted="a table [camera]: kappa is told by frames", found="none",
            do="Add it (docs/reference/rig-file.md), or leave out --calibration.",
        )  # fmt: skip
    if not quiet:
        say_reachable(kappa, plan, emulated=file.leads_to_emulated)
    shape = file.devices.camera.height, file.devices.camera.width
    judge = OwnProcess(kappa, folder / KAPPA_FILE, shape, time.perf_counter() - clock.now_s())
    try:
        yield judge
    finally:
        judge.close()
        if folder.is_dir():
            write_about(folder, kappa, judge.tally)
            if kappa.camera is not None and not (folder / CAMERA_FILE).exists():
                write_camera(folder / CAMERA_FILE, kappa.camera)


def _watchdog(file: RigFile, condition: Condition, opened: OpenRig) -> tuple[str, dict[str, Any] | None]:
    """What to say of the watchdog of this device, and the proof of it; an emulated one needs none."""
    name, board = "motor" if condition == RIGID else "actuator", board_settings(file.devices, condition)
    proof = read_proofs(file.path).get(name)
    if proof and not proof.is_of(opened.info, board.watchdog_s):
        proof = None
    text = "" if file.leads_to_emulated else remark(proof, opened.info.firmware)
    return text, asdict(proof) if proof else None


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


def _introduce(folder: Path, plan: RunPlan, opened: OpenRig, biased: bool, watchdog: str) -> None:
    rig = opened.rig
    low, high = rig.position_ticks
    print(f"folder: {folder}")
    print(f"run: {plan.specimen}, {plan.angle_deg:g} degrees, {plan.condition}, {plan.repetitions} presses")
    stiffness = "rigid" if plan.condition == RIGID else f"full stiffness {rig.max_preset_ticks} ticks"
    print(f"device: {opened.info.firmware}, positions {low} to {high} ticks, {stiffness}")
    print(f"force: {MovingAverage(rig.filter_samples, rig.rate_hz).description}")
    if watchdog:
        print(f"watchdog: {watchdog}")
    for line in laxer_guards(rig):
        print(f"guard: {line}")
    if biased:
        print("force: the load at this moment is now its zero")
    sys.stdout.flush()


def _list(file: RigFile, runs: Sequence[Run], root: Path, *, as_json: bool) -> None:
    """What is still to do, as options to copy."""
    presses = file.experiment.repetitions
    left = {run: count for run in runs if (count := missing(file, run, root))}
    if as_json:
        to_do = [run._asdict() | {"presses_left": count} for run, count in left.items()]
        print_json({"runs": len(runs), "to_do": to_do})
        return
    for run, count in left.items():
        how = how_ended(root / run.name)
        note = f"   # {how} before, {presses - count} of {presses} presses" if how else ""
        again = f" --mounting {run.mounting}" if file.experiment.mountings > 1 else ""
        print(f"--specimen {run.specimen} --angle {run.angle_deg:g} --condition {run.condition}{again}{note}")
    do = "Name one as listed; --all leads through them; --virtual emulates them."
    again = "To repeat one, move its folder away, or choose another folder with --out."
    print(f"{len(runs)} runs, {len(left)} still to do. {do if left else again}", file=sys.stderr)


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
            note(f"press {press} of {self._repetitions} done at {float(time_s):.1f} s")
        self._said = max(self._said, done)
