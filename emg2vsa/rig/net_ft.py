"""Force from an ATI Net F/T box or Ethernet Axia over RDT."""

from __future__ import annotations

import numpy as np

from emg2vsa.errors import DeviceError
from emg2vsa.rig.clock import Clock
from emg2vsa.rig.datagrams import DatagramLine, UdpLine
from emg2vsa.rig.force_sensor import ForceSample
from emg2vsa.rig.netft_config import NetFtConfig, fetch_config
from emg2vsa.rig.rdt_packets import PORT, Command, Record, parse_records, request_bytes
from emg2vsa.rig.rdt_sequence import SequenceCount, steps
from emg2vsa.rig.rdt_status import axia_status, netbox_status

FIRST_S = 1.0
"Time in which a started stream must bring its first record."
QUIET_S = 0.02
"Time in which the records of an older stream run out."
STALE_S = 0.05
FROZEN_S = 0.25
_POLL_S = 1e-3


def open_net_ft(
    host: str,
    clock: Clock,
    *,
    rdt_port: int = PORT,
    http_port: int = 80,
    buffered: bool = False,
    stale_s: float = STALE_S,
) -> NetFt:
    """The sensor at ``host``, with the scales and units its own web page gives; see `NetFt`. Raises DeviceError."""
    config = fetch_config(host, http_port)
    return NetFt(UdpLine(host, rdt_port), config, clock, buffered=buffered, stale_s=stale_s)


class NetFt:
    """A `ForceSensor` on RDT.

    Parameters
    ----------
    line, config, clock : datagrams to the box, what it says of itself, the rig's time.
    buffered : many records a datagram; less work at high rates, and up to a buffer's time later.
    stale_s : the newest record may be this old.
    frozen_s : six counts that stay the same for this long are a dead sensor: a live one is never free of noise.

    Counts since the last start: ``sequence`` (lost, late, repeated records), ``internal_lost`` (samples the box itself
    left out, told by ft_sequence), ``malformed`` (datagrams of no sensible length).
    """

    def __init__(
        self,
        line: DatagramLine,
        config: NetFtConfig,
        clock: Clock,
        *,
        buffered: bool = False,
        stale_s: float = STALE_S,
        frozen_s: float = FROZEN_S,
    ) -> None:
        self.name = f"{config.product or 'Net F/T'} at {line.name}"
        self.config = config
        self._line, self._clock = line, clock
        self._command = Command.BUFFERED if buffered else Command.STREAM
        self._stale_s, self._frozen_s = stale_s, frozen_s
        self._status = axia_status if config.axia else netbox_status
        self._scale = np.repeat([config.n_per_count, config.nm_per_count], 3)
        self._forget()

    def start(self) -> None:
        self.stop()
        self._clock.sleep_until(self._clock.now_s() + QUIET_S)
        while self._line.receive() is not None:
            pass
        self._forget()
        self._line.send(request_bytes(self._command))
        end_s = self._clock.now_s() + FIRST_S
        while not self._arrived():
            if self._clock.now_s() >= end_s:
                raise self._silent(FIRST_S)
            self._clock.sleep_until(self._clock.now_s() + _POLL_S)

    def stop(self) -> None:
        """End the stream; `start` begins another."""
        self._line.send(request_bytes(Command.STOP))

    def read(self) -> ForceSample:
        lost = sum(gap for _, _, gap in self._arrived())
        record, time_s = self._fresh()
        return self._sample(record, time_s, lost)

    def read_all(self) -> list[ForceSample]:
        arrived = self._arrived()
        self._fresh()
        return [self._sample(*one) for one in arrived]

    def bias(self) -> None:
        self._line.send(request_bytes(Command.BIAS))

    def close(self) -> None:
        try:
            self.stop()
        finally:
            self._line.close()

    def _forget(self) -> None:
        self.sequence = SequenceCount()
        self.internal_lost = self.malformed = 0
        self._newest: tuple[Record, float] | None = None
        self._changed_s = 0.0

    def _arrived(self) -> list[tuple[Record, float, int]]:
        """Record, arrival time and records lost before it, for every newer record that waits in the line."""
        arrived = []
        while (datagram := self._line.receive()) is not None:
            records = parse_records(datagram.data)
            self.malformed += not records
            # two clocks are read, so that a record could seem older than the one before
            time_s = max(self._clock.now_s() - datagram.age_s, self._newest[1] if self._newest else 0.0)
            for record in records:
                lost = self.sequence.arrived(record.rdt_sequence)
                if lost is not None:
                    back_s = steps(record.rdt_sequence, records[-1].rdt_sequence) / self.config.rate_hz
                    arrived.append((record, time_s - back_s, lost))
                    self._notice(record, time_s - back_s)
        return arrived

    def _notice(self, record: Record, time_s: float) -> None:
        if self._newest is not None:
            before = self._newest[0]
            per_record = self.config.internal_rate_hz / self.config.rate_hz
            records = steps(before.rdt_sequence, record.rdt_sequence)
            extra = steps(before.ft_sequence, record.ft_sequence) - records * per_record
            # a record more or less is the box's rounding of its rate
            self.internal_lost += round(extra) if extra > per_record / 2 else 0
        if self._newest is None or self._newest[0].counts != record.counts:
            self._changed_s = time_s
        self._newest = record, time_s

    def _fresh(self) -> tuple[Record, float]:
        if self._newest is None:
            raise DeviceError(self.name, wanted="a running stream", found="none", do="Start the sensor first.")
        record, time_s = self._newest
        now_s = self._clock.now_s()
        if now_s - time_s > self._stale_s:
            raise self._silent(now_s - time_s)
        if time_s - self._changed_s > self._frozen_s:
            raise DeviceError(
                self.name,
                wanted="a force that moves, if only by its noise",
                found=f"the same six counts for {1e3 * (time_s - self._changed_s):.0f} ms",
                do="Restart the box; check the transducer's cable.",
            )
        return record, time_s

    def _silent(self, age_s: float) -> DeviceError:
        return DeviceError(
            self.name,
            wanted=f"{self.config.rate_hz:g} records a second",
            found=f"none for {1e3 * age_s:.0f} ms",
            do="Check cable and power; the box serves one client, another program may have taken the stream.",
        )

    def _sample(self, record: Record, time_s: float, lost: int) -> ForceSample:
        wrench = np.array(record.counts) * self._scale
        return ForceSample(time_s, wrench[:3], wrench[3:], self._status(record.status), lost)
