"""Packets of Dynamixel protocol 2.0 as bytes, and what a wire that fails does to them.

Source: ROBOTIS e-Manual, DYNAMIXEL Protocol 2.0 (docs/en/dxl/protocol2.md of ROBOTIS-GIT/emanual); its example packets
are the tests.
"""

from __future__ import annotations

import struct
from collections.abc import Collection, Iterator
from enum import IntEnum

HEADER = b"\xff\xff\xfd\x00"
BROADCAST_ID = 0xFE
MOST_ID = 252
ID, LENGTH, INSTRUCTION = 4, 5, 7
"""Where these stand in a packet; the length counts everything after itself."""
LEAST_LENGTH, MOST_LENGTH = 3, 1024
"""Most: a guess, the largest packet that the public SDK sends."""
_STUFFED, _PLAIN = b"\xff\xff\xfd\xfd", b"\xff\xff\xfd"
_POLYNOMIAL = 0x8005
POSITION_COMMANDS = frozenset((116,))
"""Addresses to whose writing a motor goes: Goal Position."""
WATCHDOG_COMMANDS = frozenset((98,))
"""Bus Watchdog."""


class Instruction(IntEnum):
    """Those of the e-Manual but for Control Table Backup (0x20), to which this far end answers Instruction Error."""

    PING = 0x01
    READ = 0x02
    WRITE = 0x03
    REG_WRITE = 0x04
    ACTION = 0x05
    FACTORY_RESET = 0x06
    REBOOT = 0x08
    CLEAR = 0x10
    STATUS = 0x55
    SYNC_READ = 0x82
    SYNC_WRITE = 0x83
    FAST_SYNC_READ = 0x8A
    BULK_READ = 0x92
    BULK_WRITE = 0x93
    FAST_BULK_READ = 0x9A


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


def crc16(data: bytes) -> bytes:
    """Two bytes, low one first."""
    crc = 0
    for byte in data:
        crc = (crc << 8 & 0xFF00) ^ _CRCS[crc >> 8 ^ byte]
    return crc.to_bytes(2, "little")


def packet(device_id: int, instruction: int, parameters: bytes = b"") -> bytes:
    """The whole packet, stuffed. ``parameters`` of a status packet begin with its error byte."""
    body = (bytes((instruction,)) + parameters).replace(_PLAIN, _STUFFED)
    return sealed(HEADER + bytes((device_id,)) + (len(body) + 2).to_bytes(2, "little") + body)


def sealed(data: bytes) -> bytes:
    """``data`` and its checksum."""
    return data + crc16(data)


def unstuffed(body: bytes) -> bytes:
    """Instruction and parameters as they were meant."""
    return body.replace(_STUFFED, _PLAIN)


class DynamixelFrames:
    """As `emg2vsa.worlds.bench.faults.Frames`; commands are addresses."""

    position_commands, watchdog_commands = POSITION_COMMANDS, WATCHDOG_COMMANDS

    def without(self, data: bytes, commands: frozenset[int]) -> bytes:
        """``data`` but for the packets that write any of these addresses; what is no whole packet stays as it is.

        A packet goes as a whole, with all else that it writes. A write by way of Indirect Data is not seen."""
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
    instruction, given = body[0], body[1:]
    written: list[tuple[int, int]] = []
    if instruction in (Instruction.WRITE, Instruction.REG_WRITE) and len(given) > 2:
        written = [(int.from_bytes(given[:2], "little"), len(given) - 2)]
    elif instruction == Instruction.SYNC_WRITE and len(given) >= 4:
        written = [struct.unpack_from("<HH", given)]
    elif instruction == Instruction.BULK_WRITE:
        written = [(address, len(values)) for _, address, values in bulk_writes(given)]
    return any(start <= address < start + size for start, size in written for address in addresses)


def bulk_writes(given: bytes) -> Iterator[tuple[int, int, bytes]]:
    """Id, address and data of each part of a Bulk Write; a last one that lacks bytes is left out."""
    at = 0
    while at + 5 <= len(given):
        device_id, address, size = struct.unpack_from("<BHH", given, at)
        at += 5 + size
        if at <= len(given):
            yield device_id, address, given[at - size : at]


def sync_writes(given: bytes) -> Iterator[tuple[int, int, bytes]]:
    """The same of a Sync Write."""
    address, size = struct.unpack_from("<HH", given.ljust(4, b"\0"))
    for at in range(4, len(given) - size, size + 1):
        yield given[at], address, given[at + 1 : at + 1 + size]


def reads(instruction: int, given: bytes) -> list[tuple[int, int, int]]:
    """Id, address and size of each part of a Sync Read or Bulk Read, fast or not."""
    if instruction in (Instruction.BULK_READ, Instruction.FAST_BULK_READ):
        return list(struct.iter_unpack("<BHH", given[: len(given) // 5 * 5]))
    address, size = struct.unpack_from("<HH", given.ljust(4, b"\0"))
    return [(device_id, address, size) for device_id in given[4:]]
