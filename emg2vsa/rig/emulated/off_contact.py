"""Drivers of a bench in virtual time that leave out the bytes while nothing is near the probe.

Near the specimen, and in contact, they speak byte for byte as every other driver. Elsewhere they ask the emulated
devices themselves. The devices do, and draw, the same either way, so the same run comes out.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from emg2vsa.rig.emulated.qbmove_firmware import QbmoveFirmware
from emg2vsa.rig.emulated.rdt_box import RdtBox
from emg2vsa.rig.force.net_ft import NetFt
from emg2vsa.rig.qbmove.driver import Qbmove
from emg2vsa.rig.qbmove.packets import Command

Near = Callable[[], bool]
"""Whether the probe is in contact, or so near that it may be within a turn of the loop."""


class OffContactQbmove(Qbmove):
    """What a run sends and asks in every turn goes straight to the ``firmware``; all else over the line."""

    def __init__(self, *given: Any, firmware: QbmoveFirmware, near: Near, **named: Any) -> None:
        super().__init__(*given, **named)
        self._firmware, self._near = firmware, near

    def _tell_ticks(self, command: Command, first: int, second: int) -> None:
        if self._near():
            super()._tell_ticks(command, first, second)
        else:
            self._firmware.tell(command, first, second)

    def _ask_words(self, command: Command, count: int) -> tuple[int, ...]:
        return super()._ask_words(command, count) if self._near() else self._firmware.ask(command)


class OffContactNetFt(NetFt):
    """Records come straight from the ``box``."""

    def __init__(self, *given: Any, box: RdtBox, near: Near, **named: Any) -> None:
        self._box, self._near = box, near
        super().__init__(*given, **named)

    def _arrived(self) -> bool:
        newest = self._newest
        if newest is None or self._near():
            return super()._arrived()
        now_s = self._looked_s = self._clock.now_s()
        newest_s = newest[1]
        for record, sent_s in self._box.records_until(now_s):
            age_s = now_s - sent_s
            newest_s = max(now_s - age_s, newest_s)  # as of a datagram, whose age is told
            self._take(record, newest_s)
        return True
