"""Bus watchdog, errors of the hardware, and the faults that are put on by name."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from emg2vsa.devices.clock import VirtualClock
from emg2vsa.worlds.far_ends.dynamixel import table as t
from emg2vsa.worlds.far_ends.dynamixel.far_end import MOTOR_FAULTS
from emg2vsa.worlds.far_ends.dynamixel.firmware import BOOT_S, DynamixelFirmware
from emg2vsa.worlds.far_ends.dynamixel.packets import ALERT, DynamixelFrames, Error, Instruction, packet
from emg2vsa.worlds.far_ends.dynamixel.table import XM430_W350
from emg2vsa.worlds.far_ends.faults import FaultyWire


def put(one: Any, name: str, value: float = 1.0) -> None:
    """A fault of the table, as the bench puts it on."""
    MOTOR_FAULTS[name].strike(SimpleNamespace(firmware=one.motor), value)


def off(one: Any, name: str) -> None:
    put(one, name, MOTOR_FAULTS[name].neutral)


def turning(desk: Callable[..., Any]) -> Any:
    """On its way for about 10 s, with a watchdog of 0.2 s."""
    one = desk()
    one.hold(800)
    one.write(t.PROFILE_VELOCITY, 10, 4)
    one.write(t.BUS_WATCHDOG, 10, 1)
    one.write(t.GOAL_POSITION, 4048, 4)
    return one


def test_the_watchdog_stops_the_motor_and_refuses_goals_until_it_is_cleared(desk: Callable[..., Any]) -> None:
    """The example of the e-Manual, Bus Watchdog."""
    one = turning(desk)
    for _ in range(5):
        one.wait(0.15)
        assert one.read(t.BUS_WATCHDOG, 1) == 10, "fed by any instruction"
    angles = one.wait(1.0, period_s=0.01)
    assert angles[15] > angles[0] + 0.02
    assert angles[-1] == pytest.approx(angles[30], abs=1e-2)
    assert one.read(t.BUS_WATCHDOG, 1) == 255
    assert one.read(t.TORQUE_ENABLE, 1) == 1
    for goal, size in ((t.GOAL_POSITION, 4), (t.GOAL_CURRENT, 2), (t.GOAL_PWM, 2)):
        assert one.write(goal, 10, size) == Error.RANGE
    assert one.write(t.BUS_WATCHDOG, 10, 1) == Error.RANGE
    assert one.write(t.BUS_WATCHDOG, 0, 1) == 0
    assert one.wait(1.0)[-1] == pytest.approx(angles[-1], abs=2e-3), "it stays where it was stopped"
    held = one.read(t.PRESENT_POSITION, 4)
    assert one.write(t.GOAL_POSITION, held + 50, 4) == 0
    one.wait(3.0)
    assert one.read(t.PRESENT_POSITION, 4) == pytest.approx(held + 50, abs=4)


def test_the_watchdog_expires_after_its_time(desk: Callable[..., Any]) -> None:
    one = desk()
    one.hold(800)
    one.write(t.BUS_WATCHDOG, 10, 1)
    written_s = one.clock.now_s()
    for until_s, expected in ((0.198, 10), (0.202, 255)):
        one.clock.sleep_until(written_s + until_s)
        one.motor.advance()
        assert one.motor.table.values[t.BUS_WATCHDOG] == expected


def test_the_watchdog_is_of_the_motor_that_is_addressed_and_sleeps_without_torque(desk: Callable[..., Any]) -> None:
    one = desk()
    one.write(t.BUS_WATCHDOG, 2, 1)
    one.wait(1.0)
    assert one.read(t.BUS_WATCHDOG, 1) == 2, "torque is off"
    one.write(t.TORQUE_ENABLE, 1, 1)
    for _ in range(5):
        one.clock.sleep_until(one.clock.now_s() + 0.02)
        assert one.send(packet(2, Instruction.PING)) == b""
    assert one.motor.table.values[t.BUS_WATCHDOG] == 255


@pytest.mark.parametrize(
    ("name", "bit", "stops"),
    [("hot", 4, True), ("supply", 1, False), ("overload", 32, True), ("shock", 16, True), ("broken-encoder", 8, False)],
)
def test_an_error_of_the_hardware_alerts_until_a_reboot_and_stops_by_the_mask(
    desk: Callable[..., Any], name: str, bit: int, stops: bool
) -> None:
    one = desk()
    one.hold(800)
    put(one, name, MOTOR_FAULTS[name].usual)
    one.wait(0.1)
    off(one, name)
    one.wait(0.1)
    assert one.ask(Instruction.PING)[0] == ALERT
    assert one.write(t.LED, 1, 1) == ALERT
    assert one.write(t.LED, 2, 1) == ALERT | Error.RANGE
    assert one.read(t.HARDWARE_ERROR, 1) == bit
    assert one.read(t.TORQUE_ENABLE, 1) == (not stops)
    if stops:
        assert one.write(t.TORQUE_ENABLE, 1, 1) == ALERT | Error.RESULT_FAIL, "only a reboot ends it"
    one.motor.reset()
    assert one.send(packet(1, Instruction.PING)) == b"", "it boots"
    one.clock.sleep_until(one.clock.now_s() + BOOT_S)
    assert one.ask(Instruction.PING)[0] == 0
    assert one.write(t.TORQUE_ENABLE, 1, 1) == 0


def test_the_shutdown_mask_decides(desk: Callable[..., Any]) -> None:
    one = desk()
    one.write(t.SHUTDOWN, 1, 1)
    one.hold(800)
    put(one, "hot", 90)
    one.wait(0.1)
    assert one.read(t.TORQUE_ENABLE, 1) == 1
    assert one.read(t.PRESENT_TEMPERATURE, 1) == 90
    put(one, "supply", 9)
    one.wait(0.1)
    assert one.read(t.TORQUE_ENABLE, 1) == 0
    assert one.read(t.PRESENT_VOLTAGE, 2) == 90


def test_a_motor_that_pulls_with_all_it_has_is_overloaded_in_the_end(desk: Callable[..., Any]) -> None:
    one = desk()
    one.hold(16383)
    put(one, "jam")
    one.write(t.GOAL_POSITION, 3000, 4)
    put(one, "supply", 10)
    one.wait(0.3)
    assert one.read(t.PRESENT_CURRENT, 2) == pytest.approx(2.3 * 10 / 12 / 2.69e-3, abs=1), "a lower supply pulls less"
    off(one, "supply")
    one.wait(0.5)
    assert one.read(t.HARDWARE_ERROR, 1) == 0
    assert one.read(t.PRESENT_CURRENT, 2) == pytest.approx(2.3 / 2.69e-3, abs=1)
    one.wait(1.0)
    assert one.read(t.HARDWARE_ERROR, 1) == 32
    assert one.read(t.TORQUE_ENABLE, 1) == 0


def moved(one: Any, goal: int = 2248) -> float:
    one.write(t.GOAL_POSITION, goal, 4)
    angles_rad: list[float] = one.wait(2.0)
    return angles_rad[-1]


def test_a_jam_ends(desk: Callable[..., Any]) -> None:
    one = desk()
    one.hold(100)
    put(one, "jam")
    assert moved(one) == 0
    assert one.read(t.PRESENT_CURRENT, 2) == pytest.approx(200 * 100 / 128, abs=1)
    off(one, "jam")
    assert one.wait(2.0)[-1] > 0.25


def test_a_brown_out_takes_the_torque_and_alerts(desk: Callable[..., Any]) -> None:
    one = desk()
    one.hold(100)
    put(one, "brown-out")
    assert moved(one) == 0
    assert one.read(t.PRESENT_CURRENT, 2) == 0
    assert one.read(t.PRESENT_VOLTAGE, 2) == 50
    assert one.ask(Instruction.PING)[0] == ALERT


def test_a_weak_motor_does_no_more_than_it_can(desk: Callable[..., Any]) -> None:
    one = desk()
    one.hold(200)
    put(one, "weak", 0.1)
    one.load_nm = lambda angle_rad: 10.0 * angle_rad
    assert moved(one) == pytest.approx(0.1 / 10, abs=XM430_W350.friction_nm / 10 + 1e-3)
    off(one, "weak")
    assert one.wait(2.0)[-1] > 0.1


def test_a_frozen_and_a_jumped_encoder_read_what_is_not(desk: Callable[..., Any]) -> None:
    one = desk()
    put(one, "frozen-shaft")
    one.load_nm = lambda angle_rad: -0.1
    assert one.wait(0.3)[-1] > 0.03
    assert one.read(t.PRESENT_POSITION, 4) == 2048
    assert one.read(t.PRESENT_VELOCITY, 4) == 0
    one.load_nm = lambda angle_rad: 0.0
    one.wait(1.0)
    off(one, "frozen-shaft")
    truth = one.read(t.PRESENT_POSITION, 4)
    assert truth > 2080
    put(one, "jumped-shaft", 90)
    assert one.read(t.PRESENT_POSITION, 4) == truth + 1024
    off(one, "jumped-shaft")
    assert one.read(t.PRESENT_POSITION, 4) == truth


def test_a_current_that_reads_more(desk: Callable[..., Any]) -> None:
    one = desk()
    put(one, "current", 2690)
    assert one.read(t.PRESENT_CURRENT, 2, signed=True) == 1000
    put(one, "current", -2690)
    assert one.read(t.PRESENT_CURRENT, 2, signed=True) == -1000


def test_it_stands_behind_a_wire_that_fails(desk: Callable[..., Any]) -> None:
    """Late answers of both the wire and the device arrive, and a lost byte spoils one packet alone."""
    one = desk()
    wire = FaultyWire(one.motor, DynamixelFrames(), one.clock)

    class OnWire:
        def __call__(self, data: bytes) -> bytes:
            return wire(data)

        @property
        def due_s(self) -> float:
            due_s: float = min(wire.due_s, one.motor.due_s)
            return due_s

    one.device = OnWire()
    wire.late_s = 0.01
    before_s = one.clock.now_s()
    assert one.ask(Instruction.PING)[0] == 0
    assert one.clock.now_s() - before_s == pytest.approx(0.0105)
    wire.late_s = 0.0
    wire.lose("to device", 5)
    assert one.send(bytes.fromhex("FF FF FD 00 01 03 00 01 19 4E")) == b""
    one.clock.sleep_until(one.clock.now_s() + 0.01)
    assert one.ask(Instruction.PING)[0] == 0
    wire.reset()
    assert one.send(bytes.fromhex("FF FF FD 00 01 03 00 01 19 4E")) == b"", "it boots"


def test_a_motor_alone_moves_its_shaft_without_bytes() -> None:
    clock, asked_s = VirtualClock(), list[float]()

    class Shaft:
        def shaft_rad(self, time_s: float, motors_rad: tuple[float, float]) -> float:
            asked_s.append(time_s)
            return motors_rad[0]

    motor = DynamixelFirmware(XM430_W350, Shaft(), clock)
    assert motor.angles_rad() == (0.0, 0.0)
    clock.sleep_until(2.0)
    motor.advance()
    assert asked_s[-1] == 2.0
    assert asked_s == sorted(asked_s)
