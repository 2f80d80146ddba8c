"""Does the watchdog of this very device switch its motors off? Tried, not believed.

In the published firmware an expired watchdog clears a flag, and GET_ACTIVATE then answers 0; whether the bridge that
drives the motors drops as well, the sources do not say. So the device is left in silence, asked, and then told to move:
motors that follow a new reference are on, whatever the flag says. A device that refuses new references once its flag is
set may still go on to the last one: it is left in silence on a slow way there.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from casr.atomic import write_text_atomic
from emg2vsa.devices.board import Board
from emg2vsa.devices.clock import Clock
from emg2vsa.devices.protocols import Identity, LogColumns
from emg2vsa.devices.qbmove.ticks import LOG_COLUMNS, PROOF_KEYS, in_degrees, in_ticks
from emg2vsa.errors import DeviceError

Verdict = Literal["motors off", "flag only", "no effect", "ran away"]
_SILENCE_S = 0.5
"""Silence beyond the watchdog's own time, whose steps are 41 ms."""
_MOVE_DEG = 2.5048828125
"""0.5 mm with the paper's gear."""
_MOVED_DEG = 0.66
_WAIT_S = 0.3


@dataclass(frozen=True)
class WatchdogProof:
    """What was seen, and of which device.

    verdict : motors off, as wanted: they follow no more; flag only: the device says off and its motors still follow; no
    effect: it says on; ran away: they moved by themselves.
    """

    verdict: Verdict
    date: str
    device_id: int
    serial_number: str
    firmware: str
    full_preset: float
    "Full preset in the unit of its joint."
    watchdog_s: float
    silence_s: float
    moved_before_deg: float
    "By a reference of 2.5 degrees with the motors on."
    moved_after_deg: float
    "Way by the same reference after the silence."

    def is_of(self, info: Identity, full_preset: float, watchdog_s: float) -> bool:
        """Was it made with this device, its firmware and the watchdog's present time?"""
        same = (self.device_id, self.firmware, self.full_preset, self.watchdog_s)
        return same == (info.device_id, info.firmware, full_preset, watchdog_s)


def prove_watchdog(
    board: Board, info: Identity, clock: Clock, *, watchdog_s: float, away_sign: int, date: str
) -> WatchdogProof:
    """Motors on, a small move away from the specimen, back, silence, question, and the same move again.

    The motors are off afterwards. watchdog_s : after which they should go off by themselves, s. away_sign : which way
        leads away from the specimen.
    DeviceError : the device is lost, or does not move with its motors on: then the silence would prove nothing.
    """
    board.activate()
    here, usable = board.measurements().motors_deg, board.usable(info)
    silence_s, (low, high) = watchdog_s + _SILENCE_S, usable.position_deg
    slow_deg = board.creep_deg_per_s * (silence_s + _SILENCE_S)
    sign = away_sign if low <= here[0] + away_sign * max(_MOVE_DEG, slow_deg) <= high else -away_sign
    there = tuple(motor_deg + sign * _MOVE_DEG for motor_deg in here)
    try:
        before = _moved(board, clock, there, feed=True)
        if before < _MOVED_DEG:
            do = "Check the supply of the motors, and what holds the probe."
            found = f"{before:.2f} of {_MOVE_DEG:.2f} degrees"
            raise DeviceError(board.where, wanted="motors that follow a small move", found=found, do=do)
        _moved(board, clock, here, feed=True)
        left_deg = board.measurements().motors_deg[0]
        if slow_deg:
            board.creep(tuple(motor_deg + sign * slow_deg for motor_deg in here))
        clock.sleep_until(clock.now_s() + silence_s)
        on, drifted = board.ask_active(), sign * (board.measurements().motors_deg[0] - left_deg)
        after = _moved(board, clock, there, feed=False)
    finally:
        board.deactivate()
    astray = drifted >= slow_deg + _MOVED_DEG or drifted <= -_MOVED_DEG
    went_on = slow_deg > 0 and drifted >= board.creep_deg_per_s * (watchdog_s + _SILENCE_S / 2)
    verdict: Verdict = "motors off"
    if on or after >= _MOVED_DEG or astray or went_on:
        verdict = "no effect" if on else "ran away" if astray else "flag only"
    return WatchdogProof(
        verdict, date, info.device_id, board.serial_number(), info.firmware, usable.full_preset, watchdog_s,
        silence_s, before, after,
    )  # fmt: skip


def _moved(board: Board, clock: Clock, references_deg: Sequence[float], *, feed: bool) -> float:
    """Degrees that motor 1 moves within 0.3 s of the references; ``feed``: the watchdog is kept from running out."""
    begin_deg = board.measurements().motors_deg[0]
    end_s = clock.now_s() + _WAIT_S
    while clock.now_s() < end_s:
        board.move_motors(references_deg)
        if feed:
            board.is_active()
        clock.sleep_until(clock.now_s() + 0.02)
    return abs(board.measurements().motors_deg[0] - begin_deg)


def proof_file(rig_file: Path) -> Path:
    """Where the proofs of a rig file are kept: beside it."""
    return rig_file.with_name(f"{rig_file.stem}.watchdog.json")


def read_proofs(rig_file: Path) -> dict[str, WatchdogProof]:
    """Table of the rig file, actuator or motor, to its proof; none without a file. DeviceError for another form."""
    path = proof_file(rig_file)
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        return {}
    try:
        return {name: WatchdogProof(**in_degrees(proof, PROOF_KEYS)) for name, proof in json.loads(text).items()}
    except (OSError, ValueError, TypeError, AttributeError) as error:
        do = "Delete it, and run emg2vsa rig prove-watchdog again."
        raise DeviceError(
            path, wanted="proofs as emg2vsa rig prove-watchdog writes them", found=str(error), do=do
        ) from error


def proof_document(proof: WatchdogProof, columns: LogColumns) -> dict[str, Any]:
    """The proof as plan.json has it: of a qbmove in ticks, as in its log."""
    return in_ticks(asdict(proof), PROOF_KEYS) if columns == LOG_COLUMNS else asdict(proof)


def write_proof(rig_file: Path, name: str, proof: WatchdogProof) -> Path:
    """Keep the proof of one board beside those of the others; the file."""
    proofs = read_proofs(rig_file) | {name: proof}
    document = {each: asdict(value) for each, value in proofs.items()}
    write_text_atomic(proof_file(rig_file), json.dumps(document, indent=2) + "\n")
    return proof_file(rig_file)
