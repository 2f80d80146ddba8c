"""Frames of the qbmove protocol, and the driver against a script of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.protocols import Measurements
from emg2vsa.devices.qbmove import Generation
from emg2vsa.devices.qbmove.driver import Qbmove, Ticks
from emg2vsa.devices.qbmove.packets import (
    Command,
    find_reply,
    flushing,
    frame,
    lrc,
    parameter_list,
    ping_reply,
    wanted,
)
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK
from emg2vsa.devices.serial_line import LoopbackLine
from emg2vsa.errors import DeviceError

MEASUREMENTS = bytes.fromhex("3a3a 01 08 84 09c4 fe0c 0000 bb")  # 2500, -500, 0


@pytest.mark.parametrize(
    ("device_id", "command", "payload", "written"),
    [
        (1, 0, "", "3a3a 01 02 00 00"),
        (0, 0, "", "3a3a 00 02 00 00"),
        (1, 128, "03", "3a3a 01 03 80 03 83"),
        (1, 128, "00", "3a3a 01 03 80 00 80"),
        (1, 129, "", "3a3a 01 02 81 81"),
        (7, 130, "09c4fe0c", "3a3a 07 06 82 09c4 fe0c bd"),
        (1, 132, "", "3a3a 01 02 84 84"),
        (1, 133, "", "3a3a 01 02 85 85"),
        (1, 135, "03e84000", "3a3a 01 06 87 03e8 4000 2c"),
        (1, 143, "19", "3a3a 01 03 8f 19 96"),
        (1, 6, "0000", "3a3a 01 04 06 0000 06"),
        (1, 12, "0000", "3a3a 01 04 0c 0000 0c"),
        (1, 1, "", "3a3a 01 02 01 01"),
    ],
)
def test_a_frame_is_header_id_length_command_payload_checksum(
    device_id: int, command: int, payload: str, written: str
) -> None:
    assert frame(device_id, command, bytes.fromhex(payload)) == bytes.fromhex(written)


def test_a_reply_comes_whole() -> None:
    found = find_reply(MEASUREMENTS, wanted(1, Command.GET_MEASUREMENTS, 6))
    assert found.reply
    assert found.reply.payload == bytes.fromhex("09c4 fe0c 0000")
    assert (found.rest, found.missing, found.corrupt) == (b"", 0, 0)


@pytest.mark.parametrize("cut", range(len(MEASUREMENTS)))
def test_a_part_tells_how_many_bytes_are_missing(cut: int) -> None:
    found = find_reply(MEASUREMENTS[:cut], wanted(1, Command.GET_MEASUREMENTS, 6))
    assert found.reply is None
    assert found.missing == len(MEASUREMENTS) - cut
    assert found.rest == MEASUREMENTS[:cut]


def test_a_frame_with_a_wrong_checksum_is_counted_and_passed_over() -> None:
    corrupt = MEASUREMENTS[:6] + b"\x77" + MEASUREMENTS[7:]
    found = find_reply(corrupt + MEASUREMENTS, wanted(1, Command.GET_MEASUREMENTS, 6))
    assert found.reply
    assert found.corrupt == 1


@pytest.mark.parametrize(
    "other",
    ["3a3a 02 08 84 09c4 fe0c 0000 bb", "3a3a 01 08 89 09c4 fe0c 0000 b6", "3a3a 01 06 84 09c4 fe0c bb"],
    ids=["id", "command", "length"],
)
def test_a_frame_that_was_not_asked_for_is_no_reply(other: str) -> None:
    assert find_reply(bytes.fromhex(other), wanted(1, Command.GET_MEASUREMENTS, 6)).reply is None


@given(st.binary(max_size=300))
def test_garbage_never_raises_and_never_swallows_more_than_it_may(garbage: bytes) -> None:
    for expected in (wanted(1, 132, 6), ping_reply(None), parameter_list("v7", 1)):
        found = find_reply(garbage, expected)
        assert garbage.endswith(found.rest)
        assert found.reply is not None or found.missing > 0


@settings(max_examples=300)
@example([b":", b":", b"\x01", b"\x08", b"\x84", b"\x01", b"\x08"])
@given(st.lists(st.sampled_from([b":", b"::", b"\x01", b"\x08", b"\x84", b"\x00", MEASUREMENTS[:9]]), max_size=30))
def test_the_reply_is_found_behind_any_garbage(pieces: list[bytes]) -> None:
    expected = wanted(1, Command.GET_MEASUREMENTS, 6)
    heard, garbage = b"", b"".join(pieces)
    for place, byte in enumerate(garbage + MEASUREMENTS):
        found = find_reply(heard + bytes((byte,)), expected)
        heard = found.rest
        # garbage and the first bytes of the frame may by chance be a frame with a right checksum
        if found.reply and place >= len(garbage):
            break
    assert found.reply
    assert found.missing == 0


def test_a_ping_may_bring_a_serial_number() -> None:
    expected = ping_reply(1)
    old = find_reply(bytes.fromhex("3a3a 01 02 00 00"), expected).reply
    new = find_reply(bytes.fromhex("3a3a 01 06 00 00980001 99"), expected).reply
    assert old
    assert old.payload == b""
    assert new
    assert new.payload == bytes.fromhex("00980001")


def test_the_checksum_of_the_parameter_list_covers_176_bytes_only() -> None:
    body = bytes((12, 13)) + bytes(range(174)) + b"\x01" + bytes(1023)
    heard = b"::\x01\xb1" + body + bytes((lrc(body[:176]),))
    reply = find_reply(heard, parameter_list("v6", 1)).reply
    assert len(heard) == 4 + 1201
    assert reply
    assert reply.payload == body[1:]
    assert find_reply(heard[:-1] + bytes((lrc(body),)), parameter_list("v6", 1)).corrupt == 1


@given(st.integers(1, 255), st.sampled_from([128, 130, 132, 135]), st.binary(max_size=8))
def test_flushing_ends_a_damaged_frame_and_completes_none(device_id: int, command: int, payload: bytes) -> None:
    request = frame(device_id, command, payload)
    tail = flushing(request)
    body = request[4:]
    damaged = [body[:kept] for kept in range(1, len(body))] + [body[:k] + body[k + 1 :] for k in range(len(body))]
    for part in damaged:
        completed = (part + tail)[: len(body)]
        assert lrc(completed[:-1]) != completed[-1]
    assert b":" not in tail
    assert len(tail) == 128


IS_ACTIVE, ACTIVE, INACTIVE = "3a3a 01 02 81 81", "3a3a 01 03 81 03 82", "3a3a 01 03 81 00 81"
ACTIVATE, DEACTIVATE = "3a3a 01 03 80 03 83", "3a3a 01 03 80 00 80"


@contextmanager
def scripted(*pairs: tuple[str, str], generation: Generation = "v6", model: str = "maker-pro") -> Iterator[Qbmove]:
    left = [(bytes.fromhex(sent), bytes.fromhex(answer)) for sent, answer in pairs]

    def device(data: bytes) -> bytes:
        assert left, f"nothing more was to be sent, but {data.hex(' ')}"
        sent, answer = left.pop(0)
        assert data.hex(" ") == sent.hex(" ")
        return answer

    yield Qbmove(LoopbackLine("script", device), 1, generation=generation, model=model, clock=VirtualClock())
    assert not left, f"left over: {left}"


def test_the_script_catches_what_is_left_over() -> None:
    with pytest.raises(AssertionError, match="left over"), scripted((IS_ACTIVE, ACTIVE)):
        pass


PING = "3a3a 01 02 00 00"
MEASURED = "3a3a 01 02 84 84", "3a3a 01 08 84 09c4 fe0c 03e8 50"


@pytest.mark.parametrize(
    ("pair", "generation", "ask", "told"),
    [
        ((PING, PING), "v6", Qbmove.answers, True),
        ((PING, "3a3a 01 06 00 00980001 99"), "v7", Qbmove.answers, True),
        ((PING, "3a3a 01 06 00 00980001 99"), "v7", Qbmove.serial_number, "0009961473"),
        (MEASURED, "v6", Qbmove.ticks, Ticks(2500, -500, 1000)),
        (MEASURED, "v6", Qbmove.measurements, Measurements((27.4658203125, -5.4931640625), 10.986328125)),
        # halfway between the motors
        (MEASURED, "v6", Qbmove.position_deg, 1000 * DEG_PER_TICK),
        (("3a3a 01 02 85 85", "3a3a 01 06 85 0064 ff9c 82"), "v6", Qbmove.currents_a, (0.1, -0.1)),
        # garbage before a reply costs nothing
        ((IS_ACTIVE, "3a ff 3a3a 01 08 84 3a" + ACTIVE), "v6", Qbmove.is_active, True),
    ],
)
def test_what_is_asked_and_told(
    pair: tuple[str, str], generation: Generation, ask: Callable[[Qbmove], object], told: object
) -> None:
    with scripted(pair, generation=generation) as device:
        assert ask(device) == told
        assert device.counts.lost == 0


def test_deactivate_insists() -> None:
    with scripted((DEACTIVATE, ""), (IS_ACTIVE, ACTIVE), (DEACTIVATE, ""), (IS_ACTIVE, INACTIVE)) as device:
        device.deactivate()


def test_the_context_ends_with_motors_off_whatever_happens() -> None:
    script = scripted((DEACTIVATE, ""), (IS_ACTIVE, INACTIVE))
    with pytest.raises(KeyboardInterrupt), script as device, device:
        raise KeyboardInterrupt


@pytest.mark.parametrize("answer", [IS_ACTIVE, "", "3a3a 01 03 81 03 83", "ff 3a", ACTIVE[:-3]])
def test_a_lost_or_corrupt_reply_is_asked_for_again_after_a_flush(answer: str) -> None:
    with scripted((IS_ACTIVE, answer), ("01" + "00" * 127, ""), (IS_ACTIVE, ACTIVE)) as device:
        assert device.is_active()
        assert device.counts.lost == 1
        assert device.counts.corrupt == int(answer == "3a3a 01 03 81 03 83")
        assert device.counts.requests == 2


def test_silence_is_told_after_three_attempts() -> None:
    flush = ("01" + "00" * 127, "")
    silent = [(IS_ACTIVE, ""), flush, (IS_ACTIVE, ""), flush, (IS_ACTIVE, "")]
    with (
        scripted(*silent) as device,
        pytest.raises(
            DeviceError, match="script, qbmove 1: expected a reply to GET_ACTIVATE, but found none in 3 atte"
        ),
    ):
        device.is_active()


def test_nothing_is_commanded_before_the_limits_are_known() -> None:
    with scripted() as device, pytest.raises(DeviceError, match="Call activate first"):
        device.command(0.0, 0.5)
    with scripted() as device, pytest.raises(DeviceError, match="Call activate first"):
        device.move_motors((0.0, 0.0))
