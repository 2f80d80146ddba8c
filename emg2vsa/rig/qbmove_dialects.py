"""How the two generations of the protocol answer: acknowledgements and the replies that do not fit one length byte."""

from __future__ import annotations

from typing import Literal

from emg2vsa.rig.qbmove_packets import Command, Wanted, wanted

Generation = Literal["v6", "v7"]

_V6_PARAMETER_LIST = {1201 & 0xFF: 1201, 1151 & 0xFF: 1151}
"""LEN is the low byte of the length: of Maker Pro and Advanced 6.1.6, and of Advanced up to 6.1.5."""
_V7_LONG = {length: 32 * length for length in range(1, 256)}
_BYTE_ARGUMENT = 256
"""The firmware hands the length to its checksum function in one byte: only (1201 - 1) % 256 = 176 bytes are covered."""


def acknowledgement(generation: Generation, device_id: int | None, command: int) -> Wanted:
    """``A A`` with A = 1 or 0 in generation 6, which does not name the command; ``command A LRC`` in generation 7."""
    if generation == "v6":
        return Wanted(device_id, frozenset((0, 1)), {2: 2})
    return wanted(device_id, command, 1)


def ping_reply(device_id: int | None) -> Wanted:
    """Empty; from 7.1 on with the serial number, four bytes."""
    return Wanted(device_id, frozenset((Command.PING,)), {2: 2, 6: 6})


def parameter_list(generation: Generation, device_id: int) -> Wanted:
    """The list of all parameters."""
    commands = frozenset((Command.GET_PARAM_LIST,))
    if generation == "v6":
        return Wanted(device_id, commands, _V6_PARAMETER_LIST, lrc_modulo=_BYTE_ARGUMENT)
    return Wanted(device_id, commands, _V7_LONG)


def info_frame(device_id: int) -> Wanted:
    """The text of GET_INFO as generation 7 frames it; generation 6 sends it bare."""
    return Wanted(device_id, frozenset((Command.GET_INFO,)), _V7_LONG)
