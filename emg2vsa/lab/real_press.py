"""One run on the devices of a rig file: lock, stop requests, watchdog, judge, and what is said of them."""

from __future__ import annotations

import contextlib
import json
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Self

from casr.atomic import write_text_atomic
from casr.frame_files import write_camera
from casr.frame_files.folder import CAMERA_FILE
from emg2vsa.devices.clock import Clock, WallClock, undisturbed
from emg2vsa.devices.joints import joint_of
from emg2vsa.errors import DeviceError, SettingError
from emg2vsa.lab.judging import say_kappa, say_reachable
from emg2vsa.lab.person import Person, Say
from emg2vsa.lab.pressed import told
from emg2vsa.lab.rig_lock import rig_lock
from emg2vsa.rig.commissioning.reference import read_reference
from emg2vsa.rig.commissioning.watchdog import WatchdogProof, proof_document, read_proofs
from emg2vsa.rig.executor.execute import execute
from emg2vsa.rig.executor.guards import laxer_guards
from emg2vsa.rig.executor.motion import MovingAverage
from emg2vsa.rig.executor.plan_limits import check_plan
from emg2vsa.rig.executor.stop_requests import StopRequests
from emg2vsa.rig.kappa.judges import OwnProcess, write_about
from emg2vsa.rig.kappa.live_kappa import KAPPA_FILE, KappaPlan
from emg2vsa.rig.open_rig import OpenRig, board_settings, open_rig
from emg2vsa.rig.plan import RIGID, Condition, RunPlan
from emg2vsa.rig.record.ended import Ended
from emg2vsa.rig.record.new_folder import EMULATED_FILE
from emg2vsa.rig_file import RigFile

SAID = {
    "motors off": "the motors go off by themselves, or stop",
    "flag only": "the device says that its motors are off, and they still follow commands",
    "no effect": "the motors stay on: there is no watchdog",
    "ran away": "the motors moved by themselves when the watchdog ran out: do not use this device",
}
"Verdict on a watchdog in words."
_LOOK_S = 0.2
_TAIL_BYTES = 512


def press_for_real(file: RigFile, plan: RunPlan, folder: Path, person: Person, kappa: KappaPlan | None = None) -> Ended:
    """Carry out ``plan`` on the devices of the rig file, recorded in ``folder``. ``kappa`` : judge each press while it
    goes on. Raises as `open_rig` and `execute`."""
    clock, started = WallClock(), datetime.now(UTC)
    ended = None
    try:
        with (
            rig_lock(file.path, folder),
            _judge(file, kappa, plan, folder, clock, person) as judge,
            undisturbed(),
            StopRequests(folder) as stop,
            open_rig(file.devices, file.rig, plan.condition, clock) as opened,
        ):
            plan = _with_these_devices(file, plan, opened, person.say)
            check_plan(plan, opened.rig)
            _mark_emulated(file, folder)
            proof, columns = _proof(file, plan.condition, opened), opened.devices.actuator.columns
            _introduce(file, folder, plan, opened, proof, person.say)
            with PressLines(folder, plan.repetitions, person.note):
                ended = execute(
                    plan, opened.rig, opened.devices, folder, clock,
                    started=started, stop=stop, background=True, judge=judge,
                    facts=opened.facts | {"watchdog": proof and proof_document(proof, columns)},
                )  # fmt: skip
            person.say(told(ended, plan.repetitions, folder, opened.rig))
        if kappa is not None:
            say_kappa(folder, person)
    except DeviceError as error:
        if ended is None:
            raise
        # the run is on disk; what failed is the way a device was left
        person.warn(f"emg2vsa: {error}")
        ended = replace(ended, how="failed", cause="device", why=str(error))
    return ended


@contextlib.contextmanager
def _judge(
    file: RigFile, kappa: KappaPlan | None, plan: RunPlan, folder: Path, clock: Clock, person: Person
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
    say_reachable(kappa, plan, person, emulated=file.leads_to_emulated)
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


def with_reference(file: RigFile, plan: RunPlan, *, virtual: bool = False) -> RunPlan:
    """The plan with the current of the rigid motor, where a reference was pressed that holds for this rig file."""
    proof = read_reference(file.path, virtual=virtual) if plan.condition == RIGID else None
    holds = proof is not None and not proof.refused(datetime.now(UTC), file.rig)
    return replace(plan, motor_a_per_n=proof.a_per_n(plan.ramp_mm_per_s)) if proof and holds else plan


def _with_these_devices(file: RigFile, plan: RunPlan, opened: OpenRig, say: Say) -> RunPlan:
    """The plan without that current, where the reference was pressed by other devices, or before they were off."""
    proof = read_reference(file.path) if plan.motor_a_per_n is not None else None
    if proof is None:
        return plan
    why = proof.refused_by(opened.info, opened.serial_numbers, force_count(file, opened), datetime.now(UTC))
    if why:
        say(f"reference: it holds no more: {why}")
    return replace(plan, motor_a_per_n=None) if why else plan


def force_count(file: RigFile, opened: OpenRig) -> int | None:
    """The number of the newest sample of a force sensor that counts from when its power was switched on."""
    return opened.devices.force.read().sequence if file.devices.force.kind == "net-ft" else None


def _proof(file: RigFile, condition: Condition, opened: OpenRig) -> WatchdogProof | None:
    """Proof of the watchdog of this very device."""
    name, board = "motor" if condition == RIGID else "actuator", board_settings(file.devices, condition)
    proof = read_proofs(file.path).get(name)
    return proof if proof and proof.is_of(opened.info, opened.rig.full_preset, board.watchdog_s) else None


def remark(proof: WatchdogProof | None, firmware: str) -> str:
    """What a run should say of its watchdog; "" where it is proven."""
    if proof is None:
        return f"the watchdog of this device ({firmware}) is not proven: emg2vsa rig prove-watchdog"
    return "" if proof.verdict == "motors off" else f"watchdog tried on {proof.date[:10]}: {SAID[proof.verdict]}"


def _mark_emulated(file: RigFile, folder: Path) -> None:
    """No run of emulated devices ever passes as a measured one."""
    if file.emulated and file.leads_to_emulated:
        folder.mkdir(parents=True, exist_ok=True)
        write_text_atomic(folder / EMULATED_FILE, json.dumps(file.emulated.document(), indent=2) + "\n")


def _introduce(
    file: RigFile, folder: Path, plan: RunPlan, opened: OpenRig, proof: WatchdogProof | None, say: Say
) -> None:
    rig = opened.rig
    say(f"folder: {folder}")
    say(f"run: {plan.specimen}, {plan.angle_deg:g} degrees, {plan.condition}, {plan.repetitions} presses")
    stiffness = "rigid"
    if plan.condition != RIGID:
        joint = joint_of(file.devices.actuator.joint, rig.full_preset)
        stiffness = f"full stiffness {float(joint.stiffness_nm_per_rad(1.0)):.3g} N m/rad"
    low_deg, high_deg = rig.position_deg
    say(f"device: {opened.info.firmware}, positions {low_deg:.4g} to {high_deg:.4g} degrees, {stiffness}")
    say(f"force: {MovingAverage(rig.filter_samples, rig.rate_hz).description}")
    # an emulated watchdog needs no proof
    if not file.leads_to_emulated and (watchdog := remark(proof, opened.info.firmware)):
        say(f"watchdog: {watchdog}")
    for line in laxer_guards(rig):
        say(f"guard: {line}")
    if file.devices.force.bias:
        say("force: the load at this moment is now its zero")


class PressLines:
    """Tells which presses are over, from `__enter__` to `__exit__`.

    It reads the log, so that nobody who listens can hold up the control loop.
    """

    def __init__(self, folder: Path, repetitions: int, note: Say) -> None:
        self._log, self._repetitions, self._note, self._said = folder / "log.csv", repetitions, note, 0
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
            self._note(f"press {press} of {self._repetitions} done at {float(time_s):.1f} s")
        self._said = max(self._said, done)
