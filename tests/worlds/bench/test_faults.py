"""The faults of the emulated rig do what their words say, begin when they are told and end."""

from __future__ import annotations

import math

import pytest

from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.device_settings import RATE_HZ
from emg2vsa.devices.protocols import Devices
from emg2vsa.errors import DeviceError, SettingError
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.worlds.bench.bench import EmulatedRig
from emg2vsa.worlds.bench.faults import faults_of, put
from emg2vsa.worlds.bench.settings import EmulatedSettings
from emg2vsa.worlds.far_ends.qbmove.far_end import MOTOR_CURRENT_MA, MOTOR_TORQUE_NM

RIG = RigSettings()
LEVER_M = 0.2 * math.degrees(1) / 1000
"""Of the probe at 0.2 mm per degree."""


class Bench:
    """An emulated rig, its devices opened, motors on."""

    def __init__(self, rigid: bool = False, **settings: float) -> None:
        self.rig = EmulatedRig(EmulatedSettings(**settings), "S1", 0.0, rigid, VirtualClock())  # type: ignore[arg-type]
        self.devices: Devices = self.rig.devices()
        self.devices.actuator.activate()

    def send(self, depth_mm: float, for_s: float = 0.5) -> None:
        """Command a depth again and again."""
        for _ in range(round(for_s / 0.02)):
            self.devices.actuator.command(RIG.position_at(depth_mm), 0.0 if self.rig.rigid else 0.5)
            self.wait(0.02)

    def wait(self, duration_s: float) -> None:
        end_s = self.rig.clock.now_s() + duration_s
        while self.rig.clock.now_s() < end_s:
            self.rig.clock.sleep_until(min(end_s, self.rig.clock.now_s() + 0.1))
            self.devices.actuator.is_active()

    def depth_mm(self) -> float:
        return RIG.depth_at(self.devices.actuator.position_deg())

    def encoders_deg(self) -> tuple[float, ...]:
        at = self.devices.actuator.measurements()
        return *at.motors_deg, at.shaft_deg

    def true_n(self) -> float:
        return float(self.rig.world.force_n(self.rig.clock.now_s())[2])

    def felt_n(self) -> float:
        return float(self.devices.force.read().force_n[2])


@pytest.mark.parametrize("rigid", [False, True])
def test_position_commands_are_ignored_for_a_while_and_all_else_is_heard(rigid: bool) -> None:
    bench = Bench(rigid)
    put(bench.rig, "ignore for 1 s")
    bench.send(2.0)
    assert bench.depth_mm() == pytest.approx(0, abs=0.05)
    assert bench.devices.actuator.is_active()
    bench.wait(0.5)
    bench.send(2.0)
    assert bench.depth_mm() == pytest.approx(2, abs=0.05)


def test_a_fault_begins_at_a_force() -> None:
    bench = Bench()
    assert "at 2 N" in put(bench.rig, "stuck at 2 N")
    bench.send(3.5)
    assert not bench.rig.box.faults.stuck
    bench.send(5.0)
    assert bench.rig.box.faults.stuck


def test_a_fault_begins_at_a_time_and_ends() -> None:
    bench = Bench()
    put(bench.rig, "push 3 at 0.2 s for 0.2 s")
    felt = []
    for _ in range(3):
        felt.append(bench.felt_n())
        bench.wait(0.19)
    assert felt == pytest.approx([0, 0, 3], abs=0.1)
    bench.wait(0.1)
    assert bench.felt_n() == pytest.approx(0, abs=0.1)


def test_a_fault_to_come_is_forgotten() -> None:
    bench = Bench()
    put(bench.rig, "push 3 at 0.1 s")
    put(bench.rig, "off")
    bench.wait(0.2)
    assert bench.felt_n() == pytest.approx(0, abs=0.1)


def test_a_jammed_motor_draws_what_it_can() -> None:
    bench = Bench(rigid=True)
    put(bench.rig, "jam")
    bench.send(4.0)
    assert bench.depth_mm() == pytest.approx(0, abs=0.05)
    assert bench.devices.actuator.currents_a()[0] == pytest.approx(MOTOR_CURRENT_MA / 1000, rel=0.01)
    put(bench.rig, "jam off")
    bench.send(2.0)
    assert bench.depth_mm() == pytest.approx(2, abs=0.05)


def test_without_supply_the_electronics_answer_and_nothing_moves() -> None:
    bench = Bench()
    put(bench.rig, "brown-out")
    bench.send(4.0)
    actuator = bench.devices.actuator
    assert (bench.depth_mm(), actuator.currents_a(), actuator.is_active()) == (
        pytest.approx(0, abs=0.05),
        (0, 0),
        True,
    )
    assert b"Voltage (mV): 0" in bench.rig.answer(bytes.fromhex("3a3a 01 04 06 0000 06"))


def test_the_rigid_motor_stalls_on_what_does_not_give_way() -> None:
    bench = Bench(rigid=True, gap_sd_mm=0)
    bench.send(14.0, for_s=1.5)
    assert bench.true_n() == pytest.approx(MOTOR_TORQUE_NM / LEVER_M, rel=0.05)
    assert bench.devices.actuator.currents_a()[0] == pytest.approx(MOTOR_CURRENT_MA / 1000, rel=0.01)
    put(bench.rig, "weak 0.05")
    bench.send(0.0, for_s=1.0)
    bench.send(14.0, for_s=1.5)
    assert bench.true_n() == pytest.approx(0.05 / LEVER_M, rel=0.05)


def test_current_follows_the_load() -> None:
    currents = []
    for gap_mm in (2.0, 100.0):
        bench = Bench(rigid=True, gap_mm=gap_mm)
        bench.send(4.0)
        bench.devices.actuator.command(RIG.position_at(4.5), 0.0)
        bench.wait(0.02)
        currents.append(bench.devices.actuator.currents_a()[0])
        load_nm = bench.true_n() * LEVER_M
    assert load_nm == 0
    assert currents[0] > 2 * currents[1] > 0


@pytest.mark.parametrize(("name", "sensor"), [("motor-1", 0), ("motor-2", 1), ("shaft", 2)])
def test_a_frozen_encoder_reads_on(name: str, sensor: int) -> None:
    bench = Bench()
    bench.send(1.0)
    before = bench.encoders_deg()
    put(bench.rig, f"frozen-{name}")
    bench.send(1.2, for_s=0.2)
    after = bench.encoders_deg()
    assert [now == then for now, then in zip(after, before, strict=True)] == [k == sensor for k in range(3)]
    put(bench.rig, f"frozen-{name} off")
    bench.send(1.2)
    assert bench.depth_mm() == pytest.approx(1.2, abs=0.05)


def test_the_motor_follows_its_jumped_encoder() -> None:
    bench = Bench()
    bench.send(0.0)
    rad = bench.rig.firmware.motors.angles_rad()
    put(bench.rig, "jumped-motor-2 1000")
    bench.send(0.0)
    moved = bench.rig.firmware.motors.angles_rad()
    assert moved[0] == pytest.approx(rad[0], abs=0.005)
    assert moved[1] - rad[1] == pytest.approx(-1000 * 2 * math.pi / 32768, abs=0.005)


@pytest.mark.parametrize("flag_only", [False, True])
def test_what_an_expired_watchdog_leaves_on(flag_only: bool) -> None:
    bench = Bench()
    if flag_only:
        put(bench.rig, "flag-only")
    bench.rig.clock.sleep_until(bench.rig.clock.now_s() + 1.0)
    assert not bench.devices.actuator.is_active()
    bench.send(2.0)
    assert bench.depth_mm() == pytest.approx(2 if flag_only else 0, abs=0.05)
    bench.devices.actuator.deactivate()
    bench.send(0.0)
    assert bench.depth_mm() == pytest.approx(2 if flag_only else 0, abs=0.05)


@pytest.mark.parametrize(("late_ms", "lost"), [(4, False), (19, False), (61, True)])
def test_replies_come_late(late_ms: int, lost: bool) -> None:
    bench = Bench()
    put(bench.rig, f"late {late_ms}")
    start_s = bench.rig.clock.now_s()
    if lost:
        with pytest.raises(DeviceError):
            bench.devices.actuator.is_active()
    else:
        assert bench.devices.actuator.is_active()
        assert bench.rig.clock.now_s() - start_s == pytest.approx(late_ms / 1000, abs=1e-6)


@pytest.mark.parametrize(("line", "factor"), [("gain 0.2", 0.2), ("turned", -1), ("dead", 0), ("swapped", 0)])
def test_the_force_is_felt_wrongly(line: str, factor: float) -> None:
    bench = Bench()
    bench.send(5.0)
    put(bench.rig, line)
    bench.wait(0.01)
    true_n = bench.true_n()
    assert true_n > 3
    felt = bench.devices.force.read().force_n
    assert felt[2] == pytest.approx(factor * true_n, abs=0.1)
    assert felt[0] == pytest.approx(true_n if line == "swapped" else 0, abs=0.1)


def test_force_drifts_from_the_moment_of_the_fault() -> None:
    bench = Bench()
    bench.wait(1.0)
    put(bench.rig, "drift -2")
    bench.wait(0.5)
    assert bench.felt_n() == pytest.approx(-1, abs=0.1)


def test_force_lags_and_datagrams_come_late() -> None:
    bench = Bench()
    bench.send(3.0)
    put(bench.rig, "lag 500")
    bench.send(5.0, for_s=0.48)
    assert bench.true_n() > 3
    assert bench.felt_n() == pytest.approx(0, abs=0.1)
    put(bench.rig, "lag off")
    put(bench.rig, "delayed 30")
    bench.wait(0.1)
    before_n = bench.felt_n()
    put(bench.rig, "push 3")
    bench.wait(0.028)
    assert bench.felt_n() == pytest.approx(before_n, abs=0.1)
    bench.wait(0.006)
    assert bench.felt_n() == pytest.approx(before_n + 3, abs=0.1)


def test_the_same_seed_loses_the_same_bytes() -> None:
    answers = []
    for _ in range(2):
        bench = Bench()
        put(bench.rig, "bytes-lost 20")
        put(bench.rig, "bits-wrong 20")
        answers.append([bench.rig.answer(bytes.fromhex("3a3a01020000")) for _ in range(50)])
    assert answers[0] == answers[1]
    assert len(set(answers[0])) > 2


def test_few_and_old_frames() -> None:
    bench = Bench()
    camera = bench.devices.camera
    assert camera
    camera.frames()
    put(bench.rig, "few-frames 3")
    bench.wait(1.0)
    frames = camera.frames()
    assert len(frames) == pytest.approx(RATE_HZ / 3, abs=1)
    assert {frame.dropped for frame in frames[1:]} == {2}


def test_every_fault_that_lasts_goes_off() -> None:
    """What is left after it is what a bench without a fault has."""
    bench, whole = Bench(), Bench()
    for name, fault in faults_of(bench.rig).items():
        if fault.lasts:
            put(bench.rig, name)
    put(bench.rig, "off")
    for each in (bench, whole):
        each.rig.box.faults.drifts_from_s = 0.0
    assert vars(bench.rig.camera.faults) == vars(whole.rig.camera.faults)
    assert bench.rig.firmware.motors.faults == whole.rig.firmware.motors.faults
    left, wanted = (
        {name: value for name, value in vars(each.rig.box.faults).items() if name != "chance"}
        for each in (bench, whole)
    )
    assert left == wanted
    plain = ("mute", "deaf", "doubled", "ignored", "id_shift", "late_s", "lost_share", "wrong_share")
    assert [getattr(bench.rig.wire, name) for name in plain] == [getattr(whole.rig.wire, name) for name in plain]


@pytest.mark.parametrize(
    "line",
    [
        "late -1", "late soon", "late 1e9", "gain nan", "jam 3", "jam at 2", "jam at 2 mm", "jam at x s", "jam for 0",
        "jam for -1 s", "gap for 1 s", "weak -1", "jam on at -1 N", "jumped-motor-4", "shuffled 1", "few-frames 0", "",
        "fire", "gap 0", "gap many", "stuck 3", "off now", "mute  maybe",
    ],
)  # fmt: skip
def test_a_line_that_is_no_fault(line: str) -> None:
    rig = EmulatedRig(EmulatedSettings(), "S1", 0.0, False, VirtualClock())
    with pytest.raises(SettingError, match="help"):
        put(rig, line)
