"""Turns of a control loop as bare bytes: a command is packed and written, an answer is read, unpacked and kept."""

from __future__ import annotations

import os
import struct

import numpy as np

COMMAND, ANSWER = struct.Struct("<Bhh"), struct.Struct("<Bhhhhhf")
"Two motors' places with an identity; both places and currents, the handle, and a force."


def _sum(body: bytes) -> bytes:
    return bytes([sum(body) & 0xFF])


def turns(count: int) -> np.ndarray:
    """Readings (count, 7) of so many turns over two pipes, both ends in this process; checksums are checked."""
    to_read, to_write = os.pipe()
    from_read, from_write = os.pipe()
    kept = np.empty((count, 7))
    for turn in range(count):
        body = COMMAND.pack(1, turn % 1000, -(turn % 1000))
        os.write(to_write, body + _sum(body))
        asked = os.read(to_read, COMMAND.size + 1)
        if _sum(asked[:-1]) != asked[-1:]:
            raise ValueError("a command came damaged")
        _, first, second = COMMAND.unpack(asked[:-1])
        body = ANSWER.pack(1, first, second, 10, 10, 0, 0.5)
        os.write(from_write, body + _sum(body))
        told = os.read(from_read, ANSWER.size + 1)
        if _sum(told[:-1]) != told[-1:]:
            raise ValueError("an answer came damaged")
        kept[turn] = ANSWER.unpack(told[:-1])
    for end in (to_read, to_write, from_read, from_write):
        os.close(end)
    return kept
