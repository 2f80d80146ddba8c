"""Byte for byte the examples of the e-Manual, DYNAMIXEL Protocol 2.0; and whatever comes on the bus, whole packets are
found, and nothing else is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from emg2vsa.worlds.far_ends.dynamixel import table as t
from emg2vsa.worlds.far_ends.dynamixel.packets import (
    BYTE_GAP_S,
    HEADER,
    DynamixelFrames,
    Instruction,
    Packet,
    PacketParser,
    packet,
    unstuffed,
)
from emg2vsa.worlds.far_ends.dynamixel.table import XM430_W210

OLD = replace(XM430_W210, firmware_version=38)


@pytest.mark.parametrize(
    ("asked", "answered"),
    [
        pytest.param("FF FF FD 00 01 03 00 01 19 4E", "FF FF FD 00 01 07 00 55 00 06 04 26 65 5D", id="ping"),
        pytest.param("FF FF FD 00 FE 03 00 01 31 42", "FF FF FD 00 01 07 00 55 00 06 04 26 65 5D", id="broadcast ping"),
        pytest.param(
            "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15", "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0", id="read"
        ),
        pytest.param("FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89", "FF FF FD 00 01 04 00 55 00 A1 0C", id="write"),
    ],
)
def test_an_example_is_answered_as_the_manual_says(desk: Callable[..., Any], asked: str, answered: str) -> None:
    one = desk(OLD, 166.5 * 360 / 4096)
    assert one.send(bytes.fromhex(asked)) == bytes.fromhex(answered)


def test_answers_come_after_the_return_delay(desk: Callable[..., Any]) -> None:
    one = desk(OLD)
    assert one.motor(packet(0xFE, 1) + packet(1, 1)) == b""
    assert one.motor.due_s == pytest.approx(0.0005)
    one.clock.sleep_until(one.motor.due_s)
    assert len(one.motor(b"")) == 14
    assert one.motor.due_s == pytest.approx(0.001)
    one.clock.sleep_until(1.0)
    assert len(one.motor(b"")) == 14
    assert one.motor.due_s == float("inf")
    one.motor.table.values[t.RETURN_DELAY] = 0
    assert len(one.motor(packet(1, 1))) == 14


FRAMES = DynamixelFrames()
NASTY = st.lists(st.sampled_from((0xFF, 0xFD, 0x00, 0x01, 0x55)) | st.integers(0, 255), max_size=40).map(bytes)
PACKETS = st.tuples(st.integers(0, 254), st.integers(1, 0x9F), NASTY)


def parsed(parser: PacketParser, *pieces: bytes, now_s: float = 0.0) -> list[Packet]:
    return [found for piece in pieces for found in parser.feed(piece, now_s)]


def cut(data: bytes, places: list[int]) -> list[bytes]:
    ends = sorted({place % (len(data) + 1) for place in places} | {len(data)})
    return [data[start:end] for start, end in zip([0, *ends], ends, strict=False)]


@given(NASTY)
def test_stuffing_is_undone(body: bytes) -> None:
    whole = packet(1, 0x55, body)
    assert HEADER not in whole[1:-2]
    assert unstuffed(whole[7:-2])[1:] == body


@given(st.lists(PACKETS, min_size=1, max_size=4), st.lists(st.integers(0, 400), max_size=8))
def test_packets_are_found_however_they_are_cut(packets: list[tuple[int, int, bytes]], places: list[int]) -> None:
    data = b"".join(packet(*one) for one in packets)
    assert parsed(PacketParser(), *cut(data, places)) == [Packet(*one, True) for one in packets]


@given(st.binary(max_size=60) | NASTY, st.lists(st.integers(0, 400), max_size=6), PACKETS)
def test_any_bytes_are_read_alike_however_they_are_cut(
    garbage: bytes, places: list[int], one: tuple[int, int, bytes]
) -> None:
    data = garbage + packet(*one) + garbage
    assert parsed(PacketParser(), *cut(data, places)) == parsed(PacketParser(), data)


@given(NASTY | st.binary(max_size=60), PACKETS)
def test_after_a_pause_a_packet_is_found_whatever_came_before(garbage: bytes, one: tuple[int, int, bytes]) -> None:
    parser = PacketParser()
    parsed(parser, garbage)
    assert parsed(parser, packet(*one), now_s=2 * BYTE_GAP_S) == [Packet(*one, True)]


@given(PACKETS, PACKETS, st.integers(5, 80))
def test_a_torn_packet_does_not_swallow_the_next(
    torn: tuple[int, int, bytes], one: tuple[int, int, bytes], keep: int
) -> None:
    begun = packet(*torn)
    begun = begun[: min(keep, len(begun) - 3)]
    assert parsed(PacketParser(), begun + packet(*one))[-1] == Packet(*one, True)


@given(PACKETS, st.data())
def test_a_wrong_bit_never_passes_as_the_packet(one: tuple[int, int, bytes], data: st.DataObject) -> None:
    whole = bytearray(packet(*one))
    whole[data.draw(st.integers(0, len(whole) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    assert not [found for found in parsed(PacketParser(), bytes(whole)) if found.intact]


def test_a_length_that_cannot_be_is_skipped() -> None:
    for length in (b"\x02\x00", b"\x01\x04"):
        assert parsed(PacketParser(), HEADER + b"\x01" + length + packet(1, 1)) == [Packet(1, 1, b"", True)]


def test_a_wire_drops_what_writes_the_goal_or_the_watchdog_and_nothing_else() -> None:
    goal, gain, watchdog, both = (
        packet(1, Instruction.WRITE, address.to_bytes(2, "little") + bytes(size))
        for address, size in ((116, 4), (84, 2), (98, 1), (97, 20))
    )
    read = packet(1, Instruction.READ, bytes((116, 0, 4, 0)))
    whole = b"??" + goal + gain + both + read + watchdog + goal[:9]
    assert FRAMES.without(whole, FRAMES.position_commands) == b"??" + gain + read + watchdog + goal[:9]
    assert FRAMES.without(whole, FRAMES.watchdog_commands) == b"??" + goal + gain + read + goal[:9]
    assert FRAMES.without(whole, frozenset()) == whole


@given(st.lists(NASTY | PACKETS.map(lambda one: packet(*one)), max_size=5).map(b"".join))
def test_a_wire_that_drops_nothing_changes_nothing(data: bytes) -> None:
    assert FRAMES.without(data, frozenset()) == data


def test_an_answer_under_another_id_has_a_checksum_that_fits() -> None:
    answers = packet(1, 0x55, b"\0\xff\xff\xfd") + packet(252, 0x55, b"\0")
    assert FRAMES.renamed(answers, 1) == packet(2, 0x55, b"\0\xff\xff\xfd") + packet(0, 0x55, b"\0")
    assert FRAMES.renamed(answers[:-1], 1) == packet(2, 0x55, b"\0\xff\xff\xfd") + packet(252, 0x55, b"\0")[:-1]
