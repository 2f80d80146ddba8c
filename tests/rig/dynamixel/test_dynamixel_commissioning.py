"""The stiffness of a gain as commissioning measures it, and the proof of the watchdog, in virtual time.

Worlds that the driver was not made with: a gear of three times the friction, a sensor of five times the noise."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.dynamixel import DynamixelSettings
from emg2vsa.devices.dynamixel.driver import Dynamixel
from emg2vsa.errors import DeviceError
from emg2vsa.rig.commissioning.checks import Check, MeasuredStiffness, check_rig, measure_stiffness
from emg2vsa.rig.commissioning.hand_motion import HandMotion
from emg2vsa.rig.commissioning.watchdog import WatchdogProof, prove_watchdog
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.worlds.bench.bench import EmulatedRig
from emg2vsa.worlds.bench.faults import put
from emg2vsa.worlds.bench.settings import EmulatedSettings
from emg2vsa.worlds.far_ends.dynamixel import table
from emg2vsa.worlds.far_ends.dynamixel.table import XM430_W350

NOISE_N = EmulatedSettings().force_noise_n


class Bench:
    """A motor of this gain 2 mm and more above a specimen; its stiffness is not known."""

    def __init__(
        self, specimen: str = "S3", gain: int = 800, d_gain: int = 1500, gear: float = 0.8, *, friction: float = 1.0,
        noise: float = 1.0, watchdog_s: float = 0.5,
    ) -> None:  # fmt: skip
        self.clock, self.true = VirtualClock(), XM430_W350.stiffness_nm_per_rad(gain)
        self.settings = DynamixelSettings(
            kind="dynamixel", full_gain=gain, d_gain=d_gain, goal_current_a=0.6, watchdog_s=watchdog_s
        )
        self.rig = RigSettings(gear_mm_per_degree=gear, full_preset=self.true)
        emulated = EmulatedSettings(force_noise_n=noise * NOISE_N)
        self.bench = EmulatedRig(emulated, specimen, 0, False, self.clock, rig=self.rig, actuator=self.settings)
        self.firmware: Any = self.bench.firmware
        motor = self.firmware.motor
        motor.model = replace(motor.model, friction_nm=friction * motor.model.friction_nm)
        self.devices = self.bench.devices()
        self.hand = HandMotion(self.devices, self.rig, self.clock)

    def measured(self, preset: float) -> MeasuredStiffness:
        self.hand.start()
        return measure_stiffness(self.hand, self.rig, preset, 0.0, 40.0, lambda _: None)

    def checked(self, said: float | None) -> tuple[Check, ...]:
        return check_rig(self.hand, self.rig, Nobody(), lambda _: None, stiffness_said=said)

    def true_n(self) -> float:
        return float(np.linalg.norm(self.bench.world.force_n(self.clock.now_s())))


class Nobody:
    """Stands at the rig."""

    def towards(self, degrees: float) -> None:
        return None

    def zero_calliper(self) -> None:
        """No calliper."""

    def moved_mm(self, degrees: float) -> None:
        return None


@pytest.mark.parametrize(
    ("specimen", "gain", "d_gain", "gear", "noise"),
    [
        ("S1", 800, 1500, 0.8, 1), ("S5", 800, 1500, 0.8, 1), ("S3", 400, 800, 0.8, 1), ("S3", 200, 400, 0.5, 1),
        ("S3", 800, 1500, 0.8, 5),
    ],
)  # fmt: skip
def test_the_stiffness_of_a_gain_is_found(specimen: str, gain: int, d_gain: int, gear: float, noise: float) -> None:
    bench = Bench(specimen, gain, d_gain, gear, noise=noise)
    assert bench.measured(0.8).full_nm_per_rad == pytest.approx(bench.true, rel=0.04)
    assert bench.true_n() < 0.1, "the probe is away again"


@pytest.mark.parametrize("preset", [0.2, 0.8])
def test_both_ends_of_the_range_tell_of_the_same_joint(preset: float) -> None:
    bench = Bench("S1")
    found = bench.measured(preset)
    assert found.full_nm_per_rad == pytest.approx(bench.true, rel=0.03)
    assert found.se_nm_per_rad / found.nm_per_rad < 0.03
    assert found.nm_per_rad == pytest.approx(preset * bench.true, rel=0.03)


@pytest.mark.parametrize("specimen", ["S1", "S5"])
def test_friction_shifts_the_line_and_does_not_turn_it(specimen: str) -> None:
    bench = Bench(specimen, friction=3)
    assert bench.measured(0.2).full_nm_per_rad == pytest.approx(bench.true, rel=0.03)


def test_a_gear_that_hides_3_n_is_refused() -> None:
    bench = Bench(friction=3)
    with pytest.raises(DeviceError, match="expected a force felt where the springs give way, but found springs that"):
        bench.measured(0.8)
    assert bench.true_n() < 0.5


def test_the_rig_is_checked_and_the_stiffness_is_proposed() -> None:
    bench = Bench()
    checks = {check.key: check for check in bench.checked(None)}
    assert {key: check.good for key, check in checks.items()} == {
        "push_axis": True, "push_sign": True, "gear_mm_per_degree": True, "home_deg": True, "travel_mm": True,
        "full_stiffness_nm_per_rad": False,
    }  # fmt: skip
    stiffness = checks["full_stiffness_nm_per_rad"]
    assert stiffness.table == "actuator"
    assert stiffness.found == pytest.approx(bench.true, rel=0.03)
    assert "by 80 % and" in stiffness.remark
    assert bench.true_n() < 0.1, "the probe is away again"


def test_no_pad_within_reach_is_told() -> None:
    bench = Bench()
    bench.hand.start()
    with pytest.raises(DeviceError, match=r"expected 5 N within the reach, but found less. Use a stiffer pad"):
        measure_stiffness(bench.hand, bench.rig, 0.5, 0.0, 1.0, lambda _: None)


def proof_of(faults: tuple[str, ...] = (), watchdog_s: float = 0.5) -> WatchdogProof:
    bench = Bench(watchdog_s=watchdog_s)
    board: Any = bench.devices.actuator
    assert isinstance(board, Dynamixel)
    for fault in faults:
        put(bench.bench, fault)
    proof = prove_watchdog(board, board.info(), bench.clock, watchdog_s=watchdog_s, away_sign=-1, date="2026-11-26")
    assert not board.is_active()
    assert bench.true_n() == 0
    return proof


def test_a_motor_that_stops_in_silence_is_proven() -> None:
    proof = proof_of()
    assert (proof.verdict, proof.device_id, proof.watchdog_s) == ("motors off", 1, 0.5)
    assert proof.moved_before_deg == pytest.approx(2.5, abs=0.4)
    assert proof.moved_after_deg < 0.1


@pytest.mark.parametrize("watchdog_s", [0.1, 0.5, 2.54])
def test_the_proof_holds_for_any_time_of_the_watchdog(watchdog_s: float) -> None:
    assert proof_of(watchdog_s=watchdog_s).verdict == "motors off"
    assert proof_of(("flag-only",), watchdog_s=watchdog_s).verdict == "flag only"


def test_a_watchdog_that_is_forgotten_is_refused_before_the_torque_is_on() -> None:
    bench = Bench()
    put(bench.bench, "no-watchdog")
    board: Any = bench.devices.actuator
    with pytest.raises(DeviceError, match=r"expected 25 in Bus Watchdog \(98\), but found 0"):
        prove_watchdog(board, board.info(), bench.clock, watchdog_s=0.5, away_sign=-1, date="2026-11-26")
    assert bench.firmware.table.values[table.TORQUE_ENABLE] == 0


def test_a_watchdog_of_no_effect_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """A motor that keeps the value, and never looks at it."""
    monkeypatch.setattr("emg2vsa.worlds.far_ends.dynamixel.motor.Loop._watch", lambda loop: None)
    assert proof_of().verdict == "no effect"


def test_a_motor_that_runs_away_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """As is reported of firmware with a homing offset: it stops at a place that is not its own."""
    from emg2vsa.worlds.far_ends.dynamixel.motor import Loop

    stand = Loop.stand

    def elsewhere(loop: Loop) -> None:
        stand(loop)
        if loop._halted:
            loop._trajectory = loop._held = loop._aim = loop._held - 200

    monkeypatch.setattr(Loop, "stand", elsewhere)
    assert proof_of().verdict == "ran away"


def test_a_jammed_motor_proves_nothing() -> None:
    with pytest.raises(DeviceError, match=r"expected motors that follow a small move, but found 0.00 of 2.50 degrees"):
        proof_of(("jam",))


def test_a_pressed_shaft_is_let_go_before_the_torque_is_on() -> None:
    """A motor that its watchdog has stopped on the specimen holds it; the next activation begins without a load."""
    bench = Bench("S1")
    actuator = bench.devices.actuator
    actuator.activate()
    for k in range(200):
        actuator.command(0.05 * k, 1.0)
        bench.clock.sleep_until(bench.clock.now_s() + 0.005)
    pressed_n = bench.true_n()
    bench.clock.sleep_until(bench.clock.now_s() + 1.0)
    assert not actuator.is_active()
    assert pressed_n > 4
    assert bench.true_n() > 4, "stopped, and its torque on"
    before_s = bench.clock.now_s()
    actuator.activate()
    assert actuator.is_active()
    assert bench.true_n() < 1.0
    assert bench.clock.now_s() - before_s < 1.0


def test_a_shaft_that_is_turned_is_not_held() -> None:
    bench = Bench()
    bench.firmware.motor.speed_rad_per_s = 1.0

    def turning(_: Any) -> tuple[float, float]:
        return -2.0, 0.0

    bench.firmware._loop._loads = turning
    with pytest.raises(DeviceError, match="expected a shaft at rest within 1 s, its torque off, but found one that"):
        bench.devices.actuator.activate()
    assert bench.firmware.table.values[table.TORQUE_ENABLE] == 0
    assert math.isfinite(bench.firmware.motor.angle_rad)


@pytest.mark.parametrize(
    ("at_20_percent", "said", "good", "proportional"),
    [(20.0, 20.0, True, True), (20.0, 20.8, True, True), (20.0, 18.0, False, True), (20.0, 22.0, False, True),
     (18.9, 20.0, True, False)],
)  # fmt: skip
def test_a_stiffness_in_the_file_is_held_against_the_measured_one(
    at_20_percent: float, said: float, good: bool, proportional: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    def measured(hand: object, rig: object, preset: float, *rest: object) -> MeasuredStiffness:
        return MeasuredStiffness(preset, preset * (20.0 if preset > 0.5 else at_20_percent), 0.05, 30)

    monkeypatch.setattr("emg2vsa.rig.commissioning.checks.measure_stiffness", measured)
    found = Bench().checked(said)[-1]
    assert found.good is good
    assert ("not proportional to the gain" in found.remark) is not proportional
