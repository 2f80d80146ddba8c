"""A driver that asks the emulated box in this process itself, without datagrams.

What it says is what the driver says that speaks byte for byte (tests/worlds/bench/test_virtual_run.py).
"""

from __future__ import annotations

from typing import Any

from emg2vsa.devices.netft.driver import NetFt
from emg2vsa.devices.netft.rdt import Record
from emg2vsa.worlds.far_ends.netft.box import RdtBox

_RESTLESS_COUNTS = 100
"Noise of this standard deviation never leaves all six counts of a record as those of the one before."


class DirectNetFt(NetFt):
    """Once a stream has begun, its records come straight from the ``box``.

    all_records : somebody wants more than the newest of each turn.
    """

    def __init__(self, *given: Any, box: RdtBox, all_records: bool, **named: Any) -> None:
        self._box = box
        counts = box.settings.counts_per_force, box.settings.counts_per_torque
        noise = min(size * per_unit for size, per_unit in zip(box.settings.noise, counts, strict=True))
        self._newest_only = noise >= _RESTLESS_COUNTS and not all_records
        super().__init__(*given, **named)

    def _arrived(self) -> bool:
        if self._newest is None:
            return super()._arrived()
        now_s = self._clock.now_s()
        if now_s == self._looked_s:
            return True
        self._looked_s = now_s
        # as a stream without gaps: faults are put only into exact benches
        if self._newest_only:
            if (found := self._box.newest_until(now_s)) is not None:
                self._accept(*found, now_s)
        else:
            for record, sent_s in self._box.records_until(now_s):
                self._unread.append(self._accept(record, sent_s, now_s))
        return True

    def _accept(self, record: Record, sent_s: float, now_s: float) -> tuple[Record, float]:
        assert self._newest is not None
        newest, newest_s = self._newest
        age_s = now_s - sent_s
        newest_s = max(now_s - age_s, newest_s)  # as of a datagram, whose age is told
        if record.counts != newest.counts:
            self._changed_s = newest_s
        self._records += record.rdt_sequence - newest.rdt_sequence
        self._newest = record, newest_s
        return self._newest
