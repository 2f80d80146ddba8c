"""A scripted line: each packet must be sent and answered, in order, and none may be left over."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.dynamixel import DynamixelSettings
from emg2vsa.devices.dynamixel.driver import Dynamixel
from emg2vsa.devices.serial_line import LoopbackLine

PING, READ, WRITE, STATUS = 0x01, 0x02, 0x03, 0x55
Pair = tuple[bytes, bytes]

INFO = {
    (0, 2): 1020, (6, 1): 46, (7, 1): 1, (13, 1): 2, (11, 1): 5, (10, 1): 0, (20, 4): 0, (52, 4): 0, (48, 4): 4095,
    (36, 2): 885, (38, 2): 1193, (60, 1): 0, (63, 1): 52, (68, 1): 2, (70, 1): 0, (84, 2): 800, (82, 2): 0, (80, 2): 0,
    (144, 2): 121, (146, 1): 31,
}  # fmt: skip
"""(address, size) to the value of a motor that is set up for runs, in the order in which the driver asks."""


def crc16(data: bytes) -> int:
    """Of protocol 2.0, bit by bit: polynomial 0x8005."""
    crc = 0
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ 0x8005) & 0xFFFF if crc & 0x8000 else crc << 1
    return crc


def packet(device_id: int, *body: int) -> bytes:
    """Header, id and length before the body, checksum after it."""
    head = b"\xff\xff\xfd\0" + bytes((device_id, len(body) + 2, 0, *body))
    return head + crc16(head).to_bytes(2, "little")


def status(data: bytes = b"", error: int = 0, device_id: int = 1) -> bytes:
    return packet(device_id, STATUS, error, *data)


def number(value: int, size: int) -> bytes:
    return value.to_bytes(size, "little", signed=value < 0)


def asked(address: int, size: int) -> bytes:
    return packet(1, READ, address, 0, size, 0)


def read(address: int, size: int, value: int, error: int = 0) -> Pair:
    return asked(address, size), status(number(value, size), error)


def write(address: int, size: int, value: int, error: int = 0) -> Pair:
    return packet(1, WRITE, address, 0, *number(value, size)), status(error=error)


def written(address: int, size: int, value: int) -> tuple[Pair, Pair]:
    """Written, and read back."""
    return write(address, size, value), read(address, size, value)


def info(changed: Mapping[tuple[int, int], int] | None = None) -> list[Pair]:
    return [read(*place, value) for place, value in (INFO | dict(changed or {})).items()]


def activation(at: int = 2048, pwm_limit: int = 885, limits: tuple[int, int] = (0, 4095)) -> list[Pair]:
    """All that an activation sends to a motor with its shaft ``at`` these pulses, and its position limits."""
    return [
        *info({(36, 2): pwm_limit, (52, 4): limits[0], (48, 4): limits[1]}), read(132, 4, at),
        *written(64, 1, 0), *written(98, 1, 0), *written(84, 2, 800), *written(82, 2, 0), *written(80, 2, 0),
        *written(90, 2, 0), *written(88, 2, 0), *written(100, 2, pwm_limit), *written(102, 2, 185), *written(108, 4, 0),
        *written(112, 4, 0), read(132, 4, at), read(132, 4, at), *written(116, 4, at),
        *written(98, 1, 25), *written(64, 1, 1),
    ]  # fmt: skip


OFF = [write(64, 1, 0), write(98, 1, 0), read(64, 1, 0), read(98, 1, 0)]
PING_ONE, PONG = packet(1, PING), status(number(1020, 2) + bytes([46]))


@contextmanager
def scripted(*pairs: Pair, clock: VirtualClock | None = None, pong: bytes = PONG, **named: Any) -> Iterator[Dynamixel]:
    """The driver on such a line. pong : answer to each ping that no pair names. named : settings."""
    left = list(pairs)

    def device(data: bytes) -> bytes:
        if data == PING_ONE and (not left or left[0][0] != PING_ONE):
            return pong
        assert left, f"nothing more was to be sent, but {data.hex(' ')}"
        sent, answer = left.pop(0)
        assert data.hex(" ") == sent.hex(" ")
        return answer

    clock = clock or VirtualClock()
    settings = DynamixelSettings(kind="dynamixel", **{"full_stiffness_nm_per_rad": 4.0} | named)
    yield Dynamixel(LoopbackLine("script", device, clock), settings, clock=clock)
    assert not left, f"left over: {[sent.hex(' ') for sent, _ in left]}"
