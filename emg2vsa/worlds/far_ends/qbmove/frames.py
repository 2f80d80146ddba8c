"""Frames of the qbmove's protocol on a wire that fails."""

from __future__ import annotations

from emg2vsa.devices.qbmove.packets import HEADER, Command

POSITION_COMMANDS: frozenset[int] = frozenset((Command.SET_POS_STIFF, Command.SET_INPUTS))
WATCHDOG_COMMANDS: frozenset[int] = frozenset((Command.SET_WATCHDOG,))
_ID, _LENGTH, _COMMAND = 2, 3, 4
"""Where these stand in a frame."""


class QbmoveFrames:
    """As `emg2vsa.worlds.bench.faults.Frames`."""

    position_commands, watchdog_commands = POSITION_COMMANDS, WATCHDOG_COMMANDS

    def without(self, data: bytes, commands: frozenset[int]) -> bytes:
        """``data`` but for the frames of ``commands``; what is no whole frame stays as it is."""
        kept, at = b"", 0
        while (start := data.find(HEADER, at)) >= 0 and start + _COMMAND < len(data):
            end = start + _COMMAND + data[start + _LENGTH]
            kept += data[at : start if data[start + _COMMAND] in commands and end <= len(data) else end]
            at = end
        return kept + data[at:]

    def renamed(self, data: bytes, shift: int) -> bytes:
        """An answer under another id, which its checksum does not cover."""
        if data[:2] != HEADER or len(data) <= _ID:
            return data
        return data[:_ID] + bytes(((data[_ID] + shift) % 256,)) + data[_ID + 1 :]
