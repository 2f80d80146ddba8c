"""Byte for byte the examples of the e-Manual, DYNAMIXEL Protocol 2.0."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from emg2vsa.worlds.far_ends.dynamixel import table as t
from emg2vsa.worlds.far_ends.dynamixel.packets import crc16, packet, unstuffed
from emg2vsa.worlds.far_ends.dynamixel.table import XM430_W210

OLD = replace(XM430_W210, firmware_version=38)
_DEGREES = 360 / 4096
STATUS_OF_A_WRITE = "FF FF FD 00 01 04 00 55 00 A1 0C"


def at(*positions: int) -> tuple[float, ...]:
    return tuple((position + 0.5) * _DEGREES for position in positions)


def pair(desk: Any, asked: str) -> str:
    answer: bytes = desk.send(bytes.fromhex(asked))
    return answer.hex(" ").upper()


@pytest.mark.parametrize(
    ("asked", "answered"),
    [
        pytest.param("FF FF FD 00 01 03 00 01 19 4E", "FF FF FD 00 01 07 00 55 00 06 04 26 65 5D", id="ping"),
        pytest.param(
            "FF FF FD 00 FE 03 00 01 31 42",
            "FF FF FD 00 01 07 00 55 00 06 04 26 65 5D FF FF FD 00 02 07 00 55 00 06 04 26 6F 6D",
            id="broadcast ping",
        ),
        pytest.param(
            "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15", "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0", id="read"
        ),
        pytest.param("FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89", STATUS_OF_A_WRITE, id="write"),
        pytest.param("FF FF FD 00 01 09 00 04 68 00 C8 00 00 00 AE 8E", STATUS_OF_A_WRITE, id="reg write"),
        pytest.param("FF FF FD 00 01 04 00 06 01 A1 E6", STATUS_OF_A_WRITE, id="factory reset"),
        pytest.param("FF FF FD 00 01 03 00 08 2F 4E", STATUS_OF_A_WRITE, id="reboot"),
        pytest.param("FF FF FD 00 01 08 00 10 01 44 58 4C 22 B1 DC", STATUS_OF_A_WRITE, id="clear"),
        pytest.param(
            "FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA",
            "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0 FF FF FD 00 02 08 00 55 00 1F 08 00 00 BA BE",
            id="sync read",
        ),
        pytest.param(
            "FF FF FD 00 FE 0D 00 92 01 90 00 02 00 02 92 00 01 00 1A 05",
            "FF FF FD 00 01 06 00 55 00 77 00 C3 69 FF FF FD 00 02 05 00 55 00 24 8B A9",
            id="bulk read",
        ),
    ],
)
def test_an_example_is_answered_as_the_manual_says(desk: Callable[..., Any], asked: str, answered: str) -> None:
    two = desk(OLD, at(166, 2079))
    two.motors[0].motor.faults.supply_v = 11.9
    two.motors[1].motor.faults.temperature_c = 36
    assert pair(two, asked) == answered


def test_action_does_what_was_registered(desk: Callable[..., Any]) -> None:
    one = desk(OLD, at(166))
    pair(one, "FF FF FD 00 01 09 00 04 68 00 C8 00 00 00 AE 8E")
    assert one.read(t.REGISTERED, 1) == 1
    assert one.read(t.GOAL_VELOCITY, 4) == 0
    assert pair(one, "FF FF FD 00 01 03 00 05 02 CE") == STATUS_OF_A_WRITE
    assert one.read(t.REGISTERED, 1) == 0
    assert one.read(t.GOAL_VELOCITY, 4) == 200


def test_sync_write_and_bulk_write_are_done_and_not_answered(desk: Callable[..., Any]) -> None:
    two = desk(OLD, at(166, 2079))
    assert pair(two, "FF FF FD 00 FE 11 00 83 74 00 04 00 01 96 00 00 00 02 AA 00 00 00 82 87") == ""
    assert [motor.table.values[t.GOAL_POSITION] for motor in two.motors] == [150, 170]
    two.motors[0].table.values[t.MAX_VOLTAGE], two.motors[1].table.values[t.TEMPERATURE_LIMIT] = 150, 70
    assert pair(two, "FF FF FD 00 FE 10 00 93 01 20 00 02 00 A0 00 02 1F 00 01 00 50 B7 68") == ""
    assert two.motors[0].table.values[t.MAX_VOLTAGE] == 160
    assert two.motors[1].table.values[t.TEMPERATURE_LIMIT] == 80


def fast(desk: Callable[..., Any]) -> Any:
    """Ids 3, 7 and 4 where the examples of the fast reads have them."""
    three = desk(OLD, at(166, 2079, 1023))
    for motor, motor_id in zip(three.motors, (3, 7, 4), strict=True):
        motor.table.values[t.DEVICE_ID] = motor_id
    return three


def test_fast_sync_read_is_one_packet_of_parts(desk: Callable[..., Any]) -> None:
    three = fast(desk)
    assert pair(three, "FF FF FD 00 FE 0A 00 8A 84 00 04 00 03 07 04 20 F2") == (
        "FF FF FD 00 FE 19 00 55 00 03 A6 00 00 00 84 08 00 07 1F 08 00 00 16 CA 00 04 FF 03 00 00 D1 9E"
    )


def test_fast_bulk_read_is_one_packet_of_parts(desk: Callable[..., Any]) -> None:
    """The present PWM of the example, 421, needs a motor that pulls: read as zeros, so the checksums after it differ.

    The checksum of the example's instruction is that of the page's fast sync read by mistake."""
    three = fast(desk)
    three.motors[2].motor.faults.temperature_c = 31
    asked = packet(0xFE, 0x9A, bytes.fromhex("03 84 00 04 00 07 7C 00 02 00 04 92 00 01 00"))
    answer = three.send(asked)
    first = bytes.fromhex("FF FF FD 00 FE 14 00 55 00 03 A6 00 00 00 67 A4")
    assert answer[:16] == first
    second = first + bytes.fromhex("00 07 00 00")
    assert answer[16:22] == second[16:] + crc16(second)
    assert answer[22:25] == bytes.fromhex("00 04 1F")
    assert crc16(answer[:-2]) == answer[-2:]


def test_all_answer_a_ping_in_the_order_of_their_ids(desk: Callable[..., Any]) -> None:
    answer = fast(desk).send(packet(0xFE, 1))
    assert [answer[start + 4] for start in (0, 14, 28)] == [3, 4, 7]


def test_an_error_within_a_fast_read_keeps_its_place(desk: Callable[..., Any]) -> None:
    answer = desk(OLD, at(166, 2079)).send(packet(0xFE, 0x8A, bytes((0xBC, 2, 4, 0, 1, 2))))
    assert answer[5:7] == b"\x11\x00"
    assert len(answer) == 7 + 0x11
    assert answer[8:14] == bytes((7, 1, 0, 0, 0, 0))
    assert answer[16:22] == bytes((7, 2, 0, 0, 0, 0))


def test_a_chain_ends_at_the_motor_that_is_missing(desk: Callable[..., Any]) -> None:
    two = desk(OLD, at(166, 2079))
    answer = two.send(packet(0xFE, 0x82, bytes((132, 0, 4, 0, 1, 9, 2))))
    assert answer.hex(" ").upper() == "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0"


def test_what_looks_like_a_header_is_stuffed_both_ways(desk: Callable[..., Any]) -> None:
    one = desk()
    data = bytes.fromhex("FF FF FD FD FF FF FD")
    sent = packet(1, 3, t.REALTIME_TICK.to_bytes(2, "little") + data)
    assert data.replace(b"\xff\xff\xfd", b"\xff\xff\xfd\xfd") in sent
    assert unstuffed(sent[7:-2])[3:] == data
    # -131073 is FF FF FD FF
    assert one.write(t.OPERATING_MODE, 5, 1) == 0
    assert one.write(t.GOAL_POSITION, -131073, 4) == 0
    answer = one.send(packet(1, 2, bytes((116, 0, 4, 0))))
    assert answer[5:7] == b"\x09\x00"
    assert answer[9:14] == bytes.fromhex("FF FF FD FD FF")
    assert one.read(t.GOAL_POSITION, 4, signed=True) == -131073


def test_answers_come_after_the_return_delay_of_their_motor(desk: Callable[..., Any]) -> None:
    two = desk(OLD, at(166, 2079))
    two.motors[1].table.values[t.RETURN_DELAY] = 100
    assert two.bus(packet(0xFE, 1)) == b""
    assert two.bus.due_s == pytest.approx(0.0005)
    two.clock.sleep_until(two.bus.due_s)
    assert len(two.bus(b"")) == 14
    assert two.bus.due_s == pytest.approx(0.0007)
    two.clock.sleep_until(1.0)
    assert len(two.bus(b"")) == 14
    assert two.bus.due_s == float("inf")
    two.motors[0].table.values[t.RETURN_DELAY] = 0
    assert len(two.bus(packet(1, 1))) == 14
