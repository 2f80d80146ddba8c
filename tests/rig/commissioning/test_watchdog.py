"""The proof of a watchdog, on emulated devices that obey it and on some that do not."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from pathlib import Path

import pytest

from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.protocols import LogColumns
from emg2vsa.devices.qbmove.driver import Qbmove
from emg2vsa.devices.qbmove.packets import Command
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK, LOG_COLUMNS
from emg2vsa.devices.serial_line import LoopbackLine
from emg2vsa.errors import DeviceError
from emg2vsa.lab.real_press import remark
from emg2vsa.rig.commissioning.watchdog import (
    WatchdogProof,
    proof_document,
    proof_file,
    prove_watchdog,
    read_proofs,
    write_proof,
)
from emg2vsa.worlds.far_ends.qbmove.firmware import QbmoveFirmware
from emg2vsa.worlds.far_ends.qbmove.memory import MAKER_PRO

FULL_DEG = 3000 * DEG_PER_TICK


class Free:
    """A shaft that stays halfway between its motors."""

    def shaft_rad(self, time_s: float, motors_rad: tuple[float, float]) -> float:
        return sum(motors_rad) / 2


def proof_of(
    monkeypatch: pytest.MonkeyPatch, *, bridge_holds: bool = False, lost: bool = False, stuck: bool = False
) -> WatchdogProof:
    clock = VirtualClock()
    device = QbmoveFirmware(MAKER_PRO, Free(), clock)
    device.motors.faults.flag_only = bridge_holds
    if stuck:
        device.motors.faults.jammed = True
    if lost:
        device._handlers[Command.SET_WATCHDOG] = lambda: b""
    board = Qbmove(LoopbackLine("line", device, clock), 1, clock=clock)
    proof = prove_watchdog(board, board.info(), clock, watchdog_s=0.5, away_sign=-1, date="2026-11-23")
    assert not board.is_active()
    return proof


def test_a_device_whose_motors_go_off(monkeypatch: pytest.MonkeyPatch) -> None:
    proof = proof_of(monkeypatch)
    assert proof.verdict == "motors off"
    assert proof.moved_before_deg == pytest.approx(228 * DEG_PER_TICK, abs=24 * DEG_PER_TICK)
    assert proof.moved_after_deg <= 8 * DEG_PER_TICK


def test_a_device_that_only_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    proof = proof_of(monkeypatch, bridge_holds=True)
    assert proof.verdict == "flag only"
    assert proof.moved_after_deg > 200 * DEG_PER_TICK


def test_a_device_without_a_watchdog(monkeypatch: pytest.MonkeyPatch) -> None:
    assert proof_of(monkeypatch, lost=True).verdict == "no effect"


def test_motors_that_do_not_move_prove_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(DeviceError, match=r"motors that follow a small move, but found 0\.00 of 2\.50 degrees"):
        proof_of(monkeypatch, stuck=True)


def test_proofs_are_kept_by_board_and_read_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rig_file = tmp_path / "rig.toml"
    proof = proof_of(monkeypatch)
    assert read_proofs(rig_file) == {}
    write_proof(rig_file, "actuator", proof)
    path = write_proof(rig_file, "motor", proof)
    assert path == proof_file(rig_file) == tmp_path / "rig.watchdog.json"
    assert read_proofs(rig_file) == {"actuator": proof, "motor": proof}
    path.write_text('{"actuator": {"verdict": "motors off"}}')
    with pytest.raises(DeviceError, match=r"rig\.watchdog\.json: expected proofs as emg2vsa rig prove-watchdog writes"):
        read_proofs(rig_file)


def test_a_proof_of_before_is_read_and_a_plan_keeps_its_ticks(tmp_path: Path) -> None:
    before = {
        "verdict": "motors off", "date": "2026-11-23", "device_id": 1, "serial_number": "", "firmware": "QBMMP v6.1.0",
        "max_stiffness_ticks": 3000, "watchdog_s": 0.5, "silence_s": 1.0, "moved_before_ticks": 228,
        "moved_after_ticks": 0,
    }  # fmt: skip
    (tmp_path / "rig.watchdog.json").write_text(json.dumps({"actuator": before}))
    proof = read_proofs(tmp_path / "rig.toml")["actuator"]
    assert (proof.full_preset, proof.moved_before_deg, proof.moved_after_deg) == (FULL_DEG, 228 * DEG_PER_TICK, 0.0)
    assert proof_document(proof, LOG_COLUMNS) == before
    assert list(proof_document(proof, LOG_COLUMNS)) == list(before)
    assert proof_document(proof, LogColumns()) == asdict(proof)


def test_a_run_says_what_is_not_proven(monkeypatch: pytest.MonkeyPatch) -> None:
    good, bad = proof_of(monkeypatch), proof_of(monkeypatch, bridge_holds=True)
    assert remark(good, "QBMMP v6.1.0") == ""
    assert remark(None, "QBMMP v6.1.0").startswith("the watchdog of this device (QBMMP v6.1.0) is not proven: ")
    assert remark(bad, "QBMMP v6.1.0") == (
        "watchdog tried on 2026-11-23: the device says that its motors are off, and they still follow commands"
    )
    clock = VirtualClock()
    board = Qbmove(LoopbackLine("line", QbmoveFirmware(MAKER_PRO, Free(), clock), clock), 1, clock=clock)
    assert good.is_of(board.info(), FULL_DEG, 0.5)
    assert not good.is_of(board.info(), FULL_DEG, 1.0)
    assert not good.is_of(board.info(), FULL_DEG - DEG_PER_TICK, 0.5)
    assert not good.is_of(replace(board.info(), firmware="QBMMP v6.2.0"), FULL_DEG, 0.5)
