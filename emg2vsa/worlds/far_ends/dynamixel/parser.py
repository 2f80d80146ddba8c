"""How a Dynamixel takes bytes from its bus (e-Manual, Protocol 2.0: Reception, Byte to Byte Time)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from emg2vsa.worlds.far_ends.dynamixel.framing import (
    HEADER,
    ID,
    INSTRUCTION,
    LEAST_LENGTH,
    LENGTH,
    MOST_LENGTH,
    crc16,
    unstuffed,
)

BYTE_GAP_S = 1.5e-3
"""After a longer pause within a packet, a device waits for the next header."""


class Packet(NamedTuple):
    """What came: ``parameters`` unstuffed; ``intact``, whether the checksum fits."""

    device_id: int
    instruction: int
    parameters: bytes
    intact: bool


class PacketParser:
    """Bytes in, packets for anybody out.

    A header within a packet that is not whole yet begins a new one, as stuffing keeps headers out of bodies; that the
    firmware does so too is a guess."""

    def __init__(self) -> None:
        self._unread, self._last_s = bytearray(), 0.0

    def feed(self, data: bytes, now_s: float) -> Iterator[Packet]:
        """Packets, one at a time: what the one changes counts for the next."""
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
            intact = crc16(whole[:-2]) == whole[-2:]
            # one that is not may be torn, with the next header already in it
            del unread[: end if intact else len(HEADER)]
            body = unstuffed(whole[INSTRUCTION:-2])
            yield Packet(whole[ID], body[0], body[1:], intact)
        del unread[: -(len(HEADER) - 1)]
