"""Frames of the qbmove protocol, as pure functions.

A frame is ``:: id LEN command payload LRC``, numbers big-endian. LEN counts what follows it; the LRC is the exclusive
or of command and payload. Source: interruptions.c and command_processing.c of NMMI/qbmove-maker-pro (v6.1.0) and
NMMI/qbmove-advanced (v6.1.6); generation 7 by the client qbrobotics_driver 7.2.8, for its firmware is not public.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache, reduce
from operator import xor
from typing import NamedTuple

from emg2vsa.devices.qbmove import Generation

HEADER = b"::"
LONGEST_BODY = 128
"""Bytes after LEN that a device takes; more, and it goes back to looking for a header."""


class Command(IntEnum):
    """Command codes; what each one carries stands with its use."""

    PING = 0
    SET_ZEROS = 1
    STORE_PARAMS = 3
    STORE_DEFAULT_PARAMS = 4
    RESTORE_PARAMS = 5
    GET_INFO = 6
    BOOTLOADER = 9
    INIT_MEM = 10
    CALIBRATE = 11
    GET_PARAM_LIST = 12
    ACTIVATE = 128
    GET_ACTIVATE = 129
    SET_INPUTS = 130
    GET_INPUTS = 131
    GET_MEASUREMENTS = 132
    GET_CURRENTS = 133
    GET_CURR_AND_MEAS = 134
    SET_POS_STIFF = 135
    GET_VELOCITIES = 137
    GET_COUNTERS = 138
    SET_WATCHDOG = 143
    SET_BAUDRATE = 144


def lrc(body: bytes) -> int:
    """Checksum of command and payload; the header does not count."""
    return reduce(xor, body, 0)


def frame(device_id: int, command: int, payload: bytes = b"") -> bytes:
    """A whole frame. An acknowledgement of generation 6 is the frame of "command" 1 (done) or 0 (failed)."""
    body = bytes((command,)) + payload
    return HEADER + bytes((device_id, len(body) + 1)) + body + bytes((lrc(body),))


class Reply(NamedTuple):
    """One good reply."""

    device_id: int
    command: int
    payload: bytes


@dataclass(frozen=True)
class Wanted:
    """The reply waited for. Knowing it beforehand is what makes resynchronisation sure: nothing else can hold it up."""

    device_id: int | None
    "None: of whichever device."
    commands: frozenset[int]
    body_bytes: Mapping[int, int]
    "LEN as sent to the bytes that really follow it: long replies do not fit in the one byte."
    lrc_modulo: int | None = None
    "The LRC covers the bytes before it only up to their number modulo this; None: all of them."

    @property
    def shortest(self) -> int:
        """Bytes of the shortest such frame."""
        return len(HEADER) + 2 + min(self.body_bytes.values())

    def size_after_length(self, head: bytes) -> int | None:
        """Bytes after LEN of the frame that begins with these five, None when it is not the one waited for."""
        device_id, length, command = head[2:5]
        if self.device_id not in (None, device_id) or command not in self.commands:
            return None
        return self.body_bytes.get(length)

    def is_good(self, body: bytes) -> bool:
        """True when the checksum, the last byte of ``body``, is right."""
        covered = (len(body) - 1) % self.lrc_modulo if self.lrc_modulo else len(body) - 1
        return lrc(body[:covered]) == body[-1]


@lru_cache
def wanted(device_id: int | None, command: int, payload_bytes: int) -> Wanted:
    """The short reply to ``command``, which carries so many bytes."""
    return Wanted(device_id, frozenset((command,)), {payload_bytes + 2: payload_bytes + 2})


class Search(NamedTuple):
    """What a search through the bytes heard so far has brought."""

    reply: Reply | None
    rest: bytes
    "Bytes to search again, with those to come before them."
    missing: int
    "Bytes to wait for before another search can find more; 0 with a reply."
    corrupt: int
    "Frames that looked like the one waited for, but for their checksum."


def find_reply(heard: bytes, expected: Wanted) -> Search:
    """The first good reply among ``heard``, whatever stands before it: garbage, truncated or corrupt frames."""
    corrupt, waiting = 0, None
    start = heard.find(HEADER)
    while start >= 0:
        size = (
            expected.size_after_length(heard[start : start + 5]) if start + 5 <= len(heard) else expected.shortest - 4
        )
        if size is not None:
            body = heard[start + 4 : start + 4 + size]
            if len(body) < size:
                # a later frame may still be whole: this header may be chance
                waiting = waiting or (start, start + 4 + size - len(heard))
            elif expected.is_good(body):
                reply = Reply(heard[start + 2], body[0], body[1:-1])
                return Search(reply, heard[start + 4 + size :], 0, corrupt)
            else:
                corrupt += 1
        start = heard.find(HEADER, start + 1)
    if waiting:
        return Search(None, heard[waiting[0] :], waiting[1], corrupt)
    rest = heard[-1:] if heard.endswith(HEADER[:1]) else b""
    return Search(None, rest, expected.shortest - len(rest), corrupt)


def flushing(request: bytes) -> bytes:
    """Bytes that end a frame of which a device has lost some, without ever completing it to a valid one.

    A device waits for a lost byte without limit. Zeros leave a running checksum as it is, so one byte before them,
    equal to no checksum on the way, keeps it wrong: for ``request`` cut short anywhere, or without any one of its
    bytes, or with too large a LEN.
    """
    body = request[4:]
    completing = {lrc(body[: kept + 1]) for kept in range(len(body))} | set(body) | set(HEADER)
    harmless = next(byte for byte in range(256) if byte not in completing)
    return bytes((harmless,)) + bytes(LONGEST_BODY - 1)


_V6_PARAMETER_LIST = {1201 & 0xFF: 1201, 1151 & 0xFF: 1151}
"""LEN is the low byte of the length: of Maker Pro and Advanced 6.1.6, and of Advanced up to 6.1.5."""
_V7_LONG = {length: 32 * length for length in range(1, 256)}
_BYTE_ARGUMENT = 256
"""The firmware hands the length to its checksum function in one byte: only (1201 - 1) % 256 = 176 bytes are covered."""


def ping_reply(device_id: int | None) -> Wanted:
    """Empty; from 7.1 on with the serial number, four bytes."""
    return Wanted(device_id, frozenset((Command.PING,)), {2: 2, 6: 6})


def acknowledgement(generation: Generation, device_id: int, command: Command) -> Wanted:
    """Acknowledgement of a command that stores or sets: generation 6 names no command, but 1 (done) or 0 (failed)."""
    if generation == "v7":
        return wanted(device_id, command, 1)
    return Wanted(device_id, frozenset((0, 1)), {2: 2})


def parameter_list(generation: Generation, device_id: int) -> Wanted:
    """The list of all parameters."""
    commands = frozenset((Command.GET_PARAM_LIST,))
    if generation == "v6":
        return Wanted(device_id, commands, _V6_PARAMETER_LIST, lrc_modulo=_BYTE_ARGUMENT)
    return Wanted(device_id, commands, _V7_LONG)


def info_frame(device_id: int) -> Wanted:
    """The text of GET_INFO as generation 7 frames it; generation 6 sends it bare."""
    return Wanted(device_id, frozenset((Command.GET_INFO,)), _V7_LONG)
