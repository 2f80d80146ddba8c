"""A driver that asks the emulated qbmove in this process itself, without bytes of commands and answers.

What it says is what the driver says that speaks byte for byte (tests/worlds/bench/test_virtual_run.py).
"""

from __future__ import annotations

from typing import Any

from emg2vsa.devices.qbmove.driver import ON, Qbmove
from emg2vsa.devices.qbmove.packets import Command
from emg2vsa.worlds.far_ends.qbmove.firmware import QbmoveFirmware


class DirectQbmove(Qbmove):
    """What a run sends and asks in every turn goes straight to the ``firmware``; all else over the line."""

    def __init__(self, *given: Any, firmware: QbmoveFirmware, **named: Any) -> None:
        super().__init__(*given, **named)
        self._firmware = firmware

    def _tell_ticks(self, command: Command, first: int, second: int) -> None:
        self._firmware.tell(command, first, second)

    def _ask_words(self, command: Command, count: int) -> tuple[int, ...]:
        return self._firmware.ask(command)

    def ask_active(self) -> bool:
        """As `Qbmove.ask_active`."""
        return self._firmware.ask_active() == ON
