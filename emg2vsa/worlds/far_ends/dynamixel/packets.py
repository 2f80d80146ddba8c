"""Packets of Dynamixel protocol 2.0 as bytes, how a motor takes them from its bus, and what a wire that fails does to
them.

Source: ROBOTIS e-Manual, DYNAMIXEL Protocol 2.0 (docs/en/dxl/protocol2.md of ROBOTIS-GIT/emanual); its example packets
are the tests.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from enum import IntEnum
from typing import NamedTuple

HEADER = b"\xff\xff\xfd\x00"
BROADCAST_ID = 0xFE
MOST_ID = 252
ID, LENGTH, INSTRUCTION = 4, 5, 7
"""Where these stand in a packet; the length counts everything after itself."""
LEAST_LENGTH, MOST_LENGTH = 3, 1024
"""Most: a guess, the largest packet that the public SDK sends."""
BYTE_GAP_S = 1.5e-3
"""After a longer pause within a packet, a device waits for the next header."""
_STUFFED, _PLAIN = b"\xff\xff\xfd\xfd", b"\xff\xff\xfd"
_POLYNOMIAL = 0x8005


class Instruction(IntEnum):
    """Those that `emg2vsa.devices.dynamixel` sends; this far end answers Instruction Error to all others."""

    PING = 0x01
    READ = 0x02
    WRITE = 0x03
    STATUS = 0x55


class Error(IntEnum):
    """Number in the error byte of a status packet."""

    NONE = 0
    RESULT_FAIL = 1
    INSTRUCTION = 2
    CRC = 3
    RANGE = 4
    LENGTH = 5
    LIMIT = 6
    ACCESS = 7


ALERT = 0x80
"""Bit of the error byte: Hardware Error Status is not 0."""


def _crc_of(byte: int) -> int:
    crc = byte << 8
    for _ in range(8):
        crc = (crc << 1) ^ _POLYNOMIAL if crc & 0x8000 else crc << 1
    return crc & 0xFFFF


_CRCS = [_crc_of(byte) for byte in range(256)]


def sealed(data: bytes) -> bytes:
    """``data`` and its checksum, low byte first."""
    crc = 0
    for byte in data:
        crc = (crc << 8 & 0xFF00) ^ _CRCS[crc >> 8 ^ byte]
    return data + crc.to_bytes(2, "little")


def packet(device_id: int, instruction: int, parameters: bytes = b"") -> bytes:
    """The whole packet, stuffed. ``parameters`` of a status packet begin with its error byte."""
    body = (bytes((instruction,)) + parameters).replace(_PLAIN, _STUFFED)
    return sealed(HEADER + bytes((device_id,)) + (len(body) + 2).to_bytes(2, "little") + body)


def unstuffed(body: bytes) -> bytes:
    """Instruction and parameters as they were meant."""
    return body.replace(_STUFFED, _PLAIN)


class Packet(NamedTuple):
    """What came: ``parameters`` unstuffed; ``intact``, whether the checksum fits."""

    device_id: int
    instruction: int
    parameters: bytes
    intact: bool


class PacketParser:
    """Bytes in, packets for anybody out (e-Manual, Protocol 2.0: Reception, Byte to Byte Time).

    A header within a packet that is not whole yet begins a new one, as stuffing keeps headers out of bodies; that the
    firmware does so too is a guess."""

    def __init__(self) -> None:
        self._unread, self._last_s = bytearray(), 0.0

    def feed(self, data: bytes, now_s: float) -> Iterator[Packet]:
        """Packets that bytes at ``now_s``, s, complete, one at a time: what the one changes counts for the next."""
        unread = self._unread
        if data:
            if now_s - self._last_s > BYTE_GAP_S:
                unread.clear()
            self._last_s = now_s
        unread += data
        while (start := unread.find(HEADER)) >= 0:
            del unread[:start]
            if len(unread) < INSTRUCTION:
                return
            length = int.from_bytes(unread[LENGTH:INSTRUCTION], "little")
            if not LEAST_LENGTH <= length <= MOST_LENGTH:
                del unread[: len(HEADER)]
                continue
            end, inner = INSTRUCTION + length, unread.find(HEADER, len(HEADER))
            if 0 <= inner < end - len(HEADER):
                del unread[:inner]
                continue
            if len(unread) < end:
                return
            whole = bytes(unread[:end])
            intact = sealed(whole[:-2]) == whole
            # one that is not may be torn, with the next header already in it
            del unread[: end if intact else len(HEADER)]
            body = unstuffed(whole[INSTRUCTION:-2])
            yield Packet(whole[ID], body[0], body[1:], intact)
        del unread[: -(len(HEADER) - 1)]


class DynamixelFrames:
    """As `emg2vsa.worlds.far_ends.faults.Frames`; commands are addresses: Goal Position and Bus Watchdog."""

    position_commands: frozenset[int] = frozenset((116,))
    watchdog_commands: frozenset[int] = frozenset((98,))

    def without(self, data: bytes, commands: frozenset[int]) -> bytes:
        """``data`` but for the packets that write any of these addresses; what is no whole packet stays as it is."""
        return b"".join(part for part, whole in _parts(data) if not (whole and _writes(part, commands)))

    def renamed(self, data: bytes, shift: int) -> bytes:
        """``data`` with ``shift`` added to the id of every whole packet, and a checksum that fits."""
        return b"".join(_renamed(part, shift) if whole else part for part, whole in _parts(data))


def _renamed(part: bytes, shift: int) -> bytes:
    return sealed(part[:ID] + bytes(((part[ID] + shift) % (MOST_ID + 1),)) + part[LENGTH:-2])


def _parts(data: bytes) -> Iterator[tuple[bytes, bool]]:
    """Whole packets, True, and the bytes between and after them, False."""
    at = 0
    while (start := data.find(HEADER, at)) >= 0 and start + INSTRUCTION <= len(data):
        end = start + INSTRUCTION + int.from_bytes(data[start + LENGTH : start + INSTRUCTION], "little")
        if end < start + INSTRUCTION + LEAST_LENGTH or end > len(data):
            break
        yield data[at:start], False
        yield data[start:end], True
        at = end
    yield data[at:], False


def _writes(part: bytes, addresses: Collection[int]) -> bool:
    body = unstuffed(part[INSTRUCTION:-2])
    if body[0] != Instruction.WRITE or len(body) < 4:
        return False
    start, size = int.from_bytes(body[1:3], "little"), len(body) - 3
    return any(start <= address < start + size for address in addresses)
