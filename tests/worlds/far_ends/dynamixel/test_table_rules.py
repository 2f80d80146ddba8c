"""What may be read and written, when, and what a start forgets."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from emg2vsa.worlds.far_ends.dynamixel import table as t
from emg2vsa.worlds.far_ends.dynamixel.firmware import BOOT_S
from emg2vsa.worlds.far_ends.dynamixel.packets import Error, Instruction, packet
from emg2vsa.worlds.far_ends.dynamixel.table import MODELS, DynamixelModel

PLACES = {
    t.MODEL_NUMBER: (2, 1020), t.FIRMWARE: (1, 45), t.DEVICE_ID: (1, 1), t.BAUD_RATE: (1, 1), t.RETURN_DELAY: (1, 250),
    t.OPERATING_MODE: (1, 3), t.TEMPERATURE_LIMIT: (1, 80), t.MAX_VOLTAGE: (2, 160), t.MIN_VOLTAGE: (2, 95),
    t.PWM_LIMIT: (2, 885), t.CURRENT_LIMIT: (2, 1193), t.VELOCITY_LIMIT: (4, 200), t.MAX_POSITION: (4, 4095),
    t.SHUTDOWN: (1, 52), t.STATUS_LEVEL: (1, 2), t.POSITION_P: (2, 800), t.GOAL_PWM: (2, 885),
    t.GOAL_CURRENT: (2, 1193), t.PRESENT_POSITION: (4, 2048), t.PRESENT_VOLTAGE: (2, 120),
    t.PRESENT_TEMPERATURE: (1, 35),
}  # fmt: skip


def test_the_factory_settings_are_those_of_the_manual(desk: Callable[..., Any]) -> None:
    one = desk()
    assert {address: (size, one.read(address, size)) for address, (size, _) in PLACES.items()} == PLACES


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_each_model_says_its_number_and_limits(desk: Callable[..., Any], model: DynamixelModel) -> None:
    one = desk(model)
    assert one.ask(Instruction.PING) == (0, model.number.to_bytes(2, "little") + b"\x2d")
    assert one.read(t.CURRENT_LIMIT, 2) == model.current_limit


@pytest.mark.parametrize(
    ("address", "value", "size", "error"),
    [
        (t.POSITION_P, 16384, 2, Error.RANGE),
        (t.OPERATING_MODE, 2, 1, Error.RANGE),
        (t.STATUS_LEVEL, 3, 1, Error.RANGE),
        (t.BUS_WATCHDOG, 128, 1, Error.RANGE),
        (t.GOAL_POSITION, 1_048_576, 4, Error.RANGE),
        (t.GOAL_POSITION, 10, 2, Error.LENGTH),
        (t.GOAL_CURRENT, 0, 4, Error.LENGTH),
        (t.PRESENT_POSITION, 0, 4, Error.ACCESS),
        (t.MODEL_NUMBER, 0, 2, Error.ACCESS),
        (66, 0, 1, Error.ACCESS),
        (t.GOAL_POSITION + 1, 0, 1, Error.ACCESS),
        (700, 0, 1, Error.ACCESS),
    ],
)
def test_a_write_that_cannot_be_says_why_and_changes_nothing(
    desk: Callable[..., Any], address: int, value: int, size: int, error: Error
) -> None:
    one = desk()
    before = dict(one.motor.table.values)
    assert one.write(address, value, size) == error
    assert one.motor.table.values == before


def test_a_lower_limit_binds_the_goal(desk: Callable[..., Any]) -> None:
    one = desk()
    assert one.write(t.CURRENT_LIMIT, 100, 2) == 0
    assert one.write(t.GOAL_CURRENT, 101, 2) == Error.LIMIT
    assert one.write(t.GOAL_CURRENT, -100, 2) == 0


def test_eeprom_is_locked_while_torque_is_on(desk: Callable[..., Any]) -> None:
    one = desk()
    assert one.write(t.TORQUE_ENABLE, 1, 1) == 0
    assert one.write(t.OPERATING_MODE, 5, 1) == Error.ACCESS
    assert one.write(t.POSITION_P, 400, 2) == 0
    assert one.write(t.TORQUE_ENABLE, 0, 1) == 0
    assert one.write(t.OPERATING_MODE, 5, 1) == 0


def test_a_reset_keeps_eeprom_and_forgets_ram(desk: Callable[..., Any]) -> None:
    one = desk()
    one.write(t.OPERATING_MODE, 5, 1)
    one.write(t.DEVICE_ID, 7, 1)
    assert one.send(packet(1, Instruction.PING)) == b""
    for address, value, size in ((t.POSITION_P, 100, 2), (t.BUS_WATCHDOG, 9, 1), (t.TORQUE_ENABLE, 1, 1)):
        data = address.to_bytes(2, "little") + value.to_bytes(size, "little")
        assert one.ask(Instruction.WRITE, data, 7)[0] == 0
    one.motor.reset()
    assert one.send(packet(7, Instruction.PING)) == b"", "it boots"
    one.clock.sleep_until(one.clock.now_s() + BOOT_S)
    assert one.ask(Instruction.PING, b"", 7)[0] == 0
    values = one.motor.table.values
    assert (values[t.DEVICE_ID], values[t.OPERATING_MODE]) == (7, 5)
    assert (values[t.POSITION_P], values[t.BUS_WATCHDOG], values[t.TORQUE_ENABLE]) == (800, 0, 0)


def test_a_new_mode_brings_the_gains_and_goals_of_a_start(desk: Callable[..., Any]) -> None:
    one = desk()
    for address, value, size in (
        (t.POSITION_P, 10, 2), (t.PROFILE_VELOCITY, 50, 4), (t.CURRENT_LIMIT, 500, 2), (t.GOAL_POSITION, 9, 4),
    ):  # fmt: skip
        one.write(address, value, size)
    one.write(t.OPERATING_MODE, 5, 1)
    assert one.read(t.POSITION_P, 2) == 800
    assert one.read(t.PROFILE_VELOCITY, 4) == 0
    assert one.read(t.GOAL_CURRENT, 2) == 500
    assert one.read(t.GOAL_POSITION, 4) == 2048


def test_reads_beyond_the_table_are_refused_and_gaps_are_zeros(desk: Callable[..., Any]) -> None:
    one = desk()
    assert one.ask(Instruction.READ, bytes((66, 0, 1, 0))) == (Error.ACCESS, b"")
    assert one.ask(Instruction.READ, bytes((0x95, 0x02, 2, 0))) == (Error.ACCESS, b"")
    assert one.ask(Instruction.READ, bytes((65, 0, 5, 0))) == (0, b"\0\0\0\x02\0")
    assert one.ask(Instruction.READ, bytes((37, 0, 2, 0))) == (0, b"\x03\xa9"), "halves of two items"
    assert one.ask(Instruction.READ, bytes((65, 0, 4)))[0] == Error.LENGTH


def test_instructions_that_make_no_sense_are_told(desk: Callable[..., Any]) -> None:
    one = desk()
    assert one.ask(0x77) == (Error.INSTRUCTION, b"")
    assert one.ask(Instruction.WRITE, bytes((116, 0)))[0] == Error.LENGTH
    spoilt = packet(1, 1)[:-1] + b"\x00"
    assert one.send(spoilt)[8] == Error.CRC
    assert one.send(packet(2, 1)) == one.send(packet(2, 1)[:-1] + b"\x00") == b"", "not for it"
    assert one.send(packet(1, Instruction.STATUS, b"\0")) == b"", "an answer of another motor"
    assert one.send(packet(0xFE, Instruction.READ, bytes((132, 0, 4, 0)))) == b""
    assert one.send(packet(0xFE, Instruction.WRITE, bytes((t.LED, 0, 1)))) == b""
    assert one.motor.table.values[t.LED] == 1, "for all, and answered by nobody"


def test_a_homing_offset_shifts_what_is_read_within_a_turn(desk: Callable[..., Any]) -> None:
    one = desk(home_deg=100 * 360 / 4096 + 0.01)
    one.write(t.OPERATING_MODE, 5, 1)
    one.write(t.HOMING_OFFSET, 500, 4)
    one.motor.reset()
    one.clock.sleep_until(1.0)
    assert one.read(t.PRESENT_POSITION, 4) == 600
    one.hold(800, goal=4096 + 900)
    one.wait(4.0)
    assert one.read(t.PRESENT_POSITION, 4) == pytest.approx(4996, abs=4)
    one.write(t.TORQUE_ENABLE, 0, 1)
    one.write(t.HOMING_OFFSET, -2000, 4)
    assert one.read(t.PRESENT_POSITION, 4) == pytest.approx(4996 - 2500, abs=4)
    one.write(t.OPERATING_MODE, 3, 1)
    said = "an offset beyond 1024 does nothing in the position mode"
    assert one.read(t.PRESENT_POSITION, 4) == pytest.approx(4996 - 500, abs=4), said
    one.motor.reset()
    one.clock.sleep_until(one.clock.now_s() + 1.0)
    assert 0 <= one.read(t.PRESENT_POSITION, 4) < 4096, "whole turns are forgotten"
