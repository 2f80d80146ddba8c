"""Force from an ATI Net F/T box or Ethernet Axia over RDT."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import asdict
from operator import mul
from typing import Any

from emg2vsa.devices.board import no_address
from emg2vsa.devices.clock import Clock, awaited
from emg2vsa.devices.netft import NetFtSettings
from emg2vsa.devices.netft.box import (
    Command,
    NetFtConfig,
    Record,
    axia_status,
    fetch_config,
    netbox_status,
    parse_records,
    request_bytes,
    steps,
)
from emg2vsa.devices.netft.datagrams import DatagramLine, UdpLine
from emg2vsa.devices.protocols import ForceCounts, ForceSample
from emg2vsa.devices.registry import Around
from emg2vsa.errors import DeviceError

FIRST_S = 1.0
"Time in which a started stream must bring its first record."
QUIET_S = 0.02
"Time in which the records of an older stream run out."
STALE_S = 0.05
FROZEN_S = 0.25
SPARE_DATAGRAMS, MOST_DATAGRAMS = 64, 4096
"Taken in one turn beside those that the box has sent since the last, and at most; the others wait for the next turn."
JUMP_S = 1.0
"Records numbered so much further on than the newest, or further back, are none of this stream."
_TIMES = 4
"A network may bring each of them so often; what waits from the time of the activation is not to age the newest."
_POLL_S = 1e-3


def open_net_ft(settings: NetFtSettings, around: Around) -> NetFt:
    """The sensor of [force], with the scales and units that its own web page gives. DeviceError where none answers;
    SettingError where the file names no host: none is guessed."""
    if settings.host is None:
        raise no_address("force.host", "the address of the box", "It leaves the factory with 192.168.1.1.")
    config = fetch_config(settings.host, settings.http_port)
    line = UdpLine(settings.host, settings.rdt_port)
    return NetFt(line, config, around.clock, buffered=settings.buffered, stale_s=around.lost_s)


def about(sensor: NetFt) -> Iterator[str]:
    """What the box says of its scales and rate."""
    config = sensor.config
    yield f"{1 / config.n_per_count:g} counts/N, {1 / config.nm_per_count:g} counts/(N m)"
    yield f"{config.rate_hz:g} records a second"


def facts(sensor: NetFt, settings: NetFtSettings) -> dict[str, Any]:
    """All that the box says, for the record of a run."""
    return asdict(sensor.config)


class NetFt:
    """A `ForceSensor` on RDT.

    Parameters
    ----------
    line, config, clock : datagrams to the box, what it says of itself, the rig's time.
    buffered : many records a datagram; less work at high rates, and up to a buffer's time later.
    stale_s : the newest record may be this old.
    frozen_s : six counts that stay the same for this long are a dead sensor: a live one is never free of noise.
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
        self.config, self.rating, self.rate_hz = config, config.rating, config.rate_hz
        self._line, self._clock = line, clock
        self._command = Command.BUFFERED if buffered else Command.STREAM
        self._stale_s, self._frozen_s = stale_s, frozen_s
        self._status = axia_status if config.axia else netbox_status
        self._scale = (config.n_per_count,) * 3 + (config.nm_per_count,) * 3
        self._forget()

    def start(self) -> None:
        """Ask for records and wait for the first. DeviceError : none comes."""
        self.stop()
        self._clock.sleep_until(self._clock.now_s() + QUIET_S)
        for _ in range(MOST_DATAGRAMS):  # more come faster than they can be taken
            if self._line.receive() is None:
                break
        self._forget()
        self._line.send(request_bytes(self._command))
        if not awaited(self._clock, FIRST_S, _POLL_S, self._arrived):
            raise self._silent(FIRST_S)

    def stop(self) -> None:
        """End the stream; `start` begins another."""
        self._line.send(request_bytes(Command.STOP))

    def read(self) -> ForceSample:
        """The newest sample. DeviceError : not started, or it is too old, or it stands still."""
        self._arrived()
        return self._sample(*self._fresh())

    def read_all(self) -> list[ForceSample]:
        samples = [self._sample(record, time_s) for record, time_s in self._unread]
        self._unread.clear()
        return samples

    def counts(self) -> ForceCounts:
        lost = max(0, self._missing - self._late)  # an old record may come late a second time
        return ForceCounts(self._records, lost, self._late, self._duplicated, self._refused)

    def bias(self) -> None:
        self._line.send(request_bytes(Command.BIAS))

    def close(self) -> None:
        try:
            self.stop()
        finally:
            self._line.close()

    def _sample(self, record: Record, time_s: float) -> ForceSample:
        loads = tuple(map(mul, record.counts, self._scale))
        return ForceSample.of_loads(time_s, loads, self._status(record.status), record.ft_sequence)

    def _forget(self) -> None:
        self._records = self._missing = self._late = self._duplicated = self._refused = 0
        self._unread: deque[tuple[Record, float]] = deque(maxlen=max(1, round(self.config.rate_hz)))
        self._newest: tuple[Record, float] | None = None
        self._changed_s, self._looked_s = 0.0, self._clock.now_s()

    def _arrived(self) -> bool:
        """Take what waits in the line, but for records that come late; whether any has come since the start."""
        now_s = self._clock.now_s()
        due = (now_s - self._looked_s) * self.config.rate_hz
        self._looked_s = now_s
        for _ in range(min(SPARE_DATAGRAMS + round(_TIMES * due), MOST_DATAGRAMS)):
            if (datagram := self._line.receive()) is None:
                break
            records = parse_records(datagram.data)
            self._refused += not records
            # two clocks are read, so that a record could seem older than the one before
            time_s = max(self._clock.now_s() - datagram.age_s, self._newest[1] if self._newest else 0.0)
            for record in records:
                back_s = steps(record.rdt_sequence, records[-1].rdt_sequence) / self.config.rate_hz
                self._take(record, time_s - back_s)
        return self._newest is not None

    def _take(self, record: Record, time_s: float) -> None:
        ahead = steps(self._newest[0].rdt_sequence if self._newest else 0, record.rdt_sequence)
        if abs(ahead) > JUMP_S * self.config.rate_hz:
            self._refused += 1
        elif ahead == 0 and self._newest:
            self._duplicated += 1
        elif ahead < 0:
            self._late += 1
        else:
            self._records += 1
            self._missing += max(0, ahead - 1)
            if self._newest is None or self._newest[0].counts != record.counts:
                self._changed_s = time_s
            self._newest = record, time_s
            self._unread.append(self._newest)

    def _fresh(self) -> tuple[Record, float]:
        if self._newest is None:
            raise DeviceError(self.name, wanted="a running stream", found="none", do="Start the sensor first.")
        record, time_s = self._newest
        now_s = self._clock.now_s()
        if now_s - time_s > self._stale_s:
            raise self._silent(now_s - time_s)
        if time_s - self._changed_s > self._frozen_s:
            wanted, do = "a force that moves, if only by its noise", "Restart the box; check the transducer's cable."
            found = f"the same six counts for {1e3 * (time_s - self._changed_s):.0f} ms"
            raise DeviceError(self.name, wanted=wanted, found=found, do=do)
        return record, time_s

    def _silent(self, age_s: float) -> DeviceError:
        wanted, found = f"{self.config.rate_hz:g} records a second", f"none for {1e3 * age_s:.0f} ms"
        do = "Check cable and power; the box serves one client, another program may have taken the stream."
        return DeviceError(self.name, wanted=wanted, found=found, do=do)
