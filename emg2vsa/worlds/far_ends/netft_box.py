"""An ATI Net F/T box or Ethernet Axia up to its sockets: requests in, records out as time goes on, and its page.

Behaviour after ATI manuals 9620-05 and 9610-05: one client, the newest request wins; rates are whole fractions of 7000
a second; bias is not answered. The noise is a guess.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from operator import add, gt, mul, sub, truediv

import numpy as np

from emg2vsa.devices.netft import INTERNAL_RATE_HZ
from emg2vsa.devices.netft.box import LARGEST_BUFFER, Command, Record, parse_request, record_bytes
from emg2vsa.worlds.far_ends.netft_faults import BoxFaults, Client, FaultyPost

NETBOX_SATURATED = 0x80020000
AXIA_OUT_OF_RANGE = 0xC0000000
Wrenches = Callable[[Sequence[float]], Sequence[Sequence[float]]]
"""(R,) times, s, that never go back, to (R, 6) force, N, and torque, N·m, on the sensor at these times."""


Counts = tuple[int, ...]
LEAST_COUNT, MOST_COUNT = -(2**31), 2**31 - 1
NO_LOAD = (0.0,) * 6
_NONE = range(0)
_BLOCK = 256
"Draws made at once; the counts come out the same for any number."


@dataclass(frozen=True)
class BoxSettings:
    """How the box is set up.

    rate_hz : records a second asked for; the box takes the next whole fraction of 7000 that is not below.
    counts_per_force, counts_per_torque, force_unit, torque_unit : scales and units as on the box's page.
    n_per_unit, nm_per_unit : size of these units, N and N·m.
    buffer : records a datagram in buffered mode, 1 to 40.
    rating : largest force and torque along x, y, z in these units; beyond, the status says so. Mini45 SI-145-5.
    noise : standard deviation of force and torque in these units.
    axia : an Ethernet Axia, else a Net F/T box. serial : number of its calibration.
    """

    rate_hz: float = 1000.0
    counts_per_force: int = 1_000_000
    counts_per_torque: int = 1_000_000
    force_unit: str = "N"
    torque_unit: str = "Nm"
    n_per_unit: float = 1.0
    nm_per_unit: float = 1.0
    buffer: int = 10
    rating: tuple[float, ...] = (145.0, 145.0, 290.0, 5.0, 5.0, 5.0)
    noise: tuple[float, float] = (0.005, 0.0001)
    axia: bool = False
    serial: str = "FT00000"
    seed: int = 0

    @cached_property
    def divisor(self) -> int:
        """Internal samples from record to record."""
        return max(1, math.floor(INTERNAL_RATE_HZ / self.rate_hz))


class NoisyCounts:
    """One record after the other. Of a load that stays, all counts of a block are made at once.

    Parameters
    ----------
    noise : standard deviation of force and torque. counts_per_unit : of force and torque. seed : of the draws.
    """

    def __init__(self, noise: tuple[float, float], counts_per_unit: tuple[int, int], seed: int) -> None:
        self._rng, self._size = np.random.default_rng(seed), np.repeat(noise, 3)
        # plain numbers too: six at a time are too few for arrays to pay
        self._per_unit = np.repeat(counts_per_unit, 3)
        self._each_per_unit: list[int] = self._per_unit.tolist()
        self._at = _BLOCK
        self._before: tuple[Sequence[float], Sequence[float]] = NO_LOAD, NO_LOAD
        "Load and bias of the record before."
        self._under: list[Counts] | None = None
        "Counts of the block under that load, once it has come twice."

    def of(self, load: Sequence[float], bias: Sequence[float]) -> Counts:
        """Six counts of the next record, under a load less a bias."""
        if self._at == _BLOCK:
            self._draw()
        row, self._at = self._at, self._at + 1
        if (load, bias) != self._before:
            self._before, self._under = (load, bias), None
            noisy = map(mul, map(add, map(sub, load, bias), self._rows[row]), self._each_per_unit)
            counts = tuple(map(round, noisy))
            if min(counts) >= LEAST_COUNT and max(counts) <= MOST_COUNT:
                return counts
            return tuple([max(LEAST_COUNT, min(MOST_COUNT, count)) for count in counts])  # far out of range
        if self._under is None:
            noisy_units = np.subtract(load, bias) + self._noise
            counts_of_block = np.rint(noisy_units * self._per_unit).clip(LEAST_COUNT, MOST_COUNT).astype(np.int64)
            self._under = list(map(tuple, counts_of_block.tolist()))
        return self._under[row]

    def skip(self, records: int) -> None:
        """So many records that nobody looks at: those after them come out as if these had been made."""
        self._at += records
        while self._at > _BLOCK:
            left = self._at - _BLOCK
            self._draw()
            self._at = left

    def _draw(self) -> None:
        self._noise = self._size * self._rng.standard_normal((_BLOCK, 6))
        self._rows, self._at, self._under = self._noise.tolist(), 0, None


@dataclass
class _Stream:
    client: Client
    left: float
    per_datagram: int
    tick: int
    "Internal sample of the next record."
    rdt_sequence: int = 0
    last_s: float = 0.0
    waiting: list[bytes] = field(default_factory=list)


class RdtBox:
    """The box.

    Parameters
    ----------
    wrenches : on the sensor, asked once for all records that are due.
    settings : how it is set up.
    """

    def __init__(self, wrenches: Wrenches, settings: BoxSettings | None = None) -> None:
        self.settings = s = settings or BoxSettings()
        self.faults = BoxFaults()
        self._wrenches = wrenches
        # plain numbers: six at a time are too few for arrays to pay
        self._size = [s.n_per_unit] * 3 + [s.nm_per_unit] * 3
        self._divisor = s.divisor
        self._wrench: Sequence[float] = NO_LOAD
        self._of_wrench: Sequence[float] = NO_LOAD
        self._noisy = NoisyCounts(s.noise, (s.counts_per_force, s.counts_per_torque), s.seed)
        self._alarm = AXIA_OUT_OF_RANGE if s.axia else NETBOX_SATURATED
        self._bias: Sequence[float] = NO_LOAD
        self._judged: Sequence[float] = NO_LOAD
        "The load of the record before."
        self._beyond = False
        "Whether that load is beyond the rating."
        self._skipped = 0
        self._stream: _Stream | None = None
        self._post = FaultyPost()
        self._counts: tuple[int, ...] = (0,) * 6

    @property
    def next_s(self) -> float:
        """Time of the next record, s; inf when nothing streams and nothing is on its way."""
        return min(self._stream.tick / INTERNAL_RATE_HZ if self._stream else math.inf, self._post.due_s)

    def request(self, data: bytes, client: Client, time_s: float) -> None:
        """A datagram came for RDT; ``client`` takes the datagrams for its sender."""
        parsed = parse_request(data)
        if parsed is None:
            return
        self.run_until(time_s)
        command, count = parsed
        if command == Command.STOP:
            self._stream = None
        elif command in (Command.STREAM, Command.BUFFERED):
            per_datagram = min(self.settings.buffer, LARGEST_BUFFER) if command == Command.BUFFERED else 1
            first = math.floor(time_s * INTERNAL_RATE_HZ) + 1
            self._stream = _Stream(client, count or math.inf, per_datagram, first)
            self._post.forget()
        elif command == Command.BIAS:
            (self._bias,) = self._loads([time_s])

    def run_until(self, time_s: float) -> None:
        """Send every record that is due by ``time_s``, s."""
        stream = self._stream
        for record, at_s in self.records_until(time_s):
            assert stream is not None
            stream.waiting.append(record_bytes(record))
            if len(stream.waiting) == stream.per_datagram:
                self._send(stream, at_s)
        if stream and stream.waiting and not stream.left:
            self._send(stream, stream.last_s)
        self._post.deliver(time_s)

    def newest_until(self, time_s: float) -> tuple[Record, float] | None:
        """The newest of the records that are due, and when it is measured, s. Nobody looks at those before it."""
        stream, ticks = self._due(time_s)
        if stream is None:
            return None
        faults, many, at_s = self.faults, len(ticks), stream.last_s
        if not faults.stuck:
            self._noisy.skip(many - 1)
        (load,) = self._loads((at_s,))
        if faults.skip:
            self._skipped, faults.skip = self._skipped + faults.skip, 0
        number = stream.rdt_sequence = (stream.rdt_sequence + many) % 2**32
        status, counts = self._read(load)
        return Record(number, (ticks[-1] + self._skipped) % 2**32, status, counts), at_s

    def records_until(self, time_s: float) -> list[tuple[Record, float]]:
        """Every record that is due, and when it is measured, s. Who takes them here gets no datagrams of them."""
        stream, ticks = self._due(time_s)
        return [] if stream is None else self._measured(stream, ticks)

    def _due(self, time_s: float) -> tuple[_Stream | None, range]:
        """The stream, None where nothing is due; internal samples of what is due."""
        if (stream := self._stream) is None:
            return None, _NONE
        until_s, first, divisor = time_s + 1e-9, stream.tick, self._divisor
        last = math.floor(until_s * INTERNAL_RATE_HZ) + 1  # a product that is rounded may be off
        while last / INTERNAL_RATE_HZ > until_s:
            last -= 1
        count = min((last - first) // divisor + 1, stream.left)
        if count <= 0:
            return None, _NONE
        ticks = range(first, first + int(count) * divisor, divisor)
        stream.tick, stream.last_s, stream.left = ticks.stop, ticks[-1] / INTERNAL_RATE_HZ, stream.left - len(ticks)
        if not stream.left:
            self._stream = None
        return stream, ticks

    def _read(self, load: Sequence[float]) -> tuple[int, tuple[int, ...]]:
        faults = self.faults
        if load is not self._judged:
            self._judged, self._beyond = load, True in map(gt, map(abs, load), self.settings.rating)
        if not faults.stuck:
            self._counts = self._noisy.of(load, self._bias)
        if faults.overflow:
            self._counts = (MOST_COUNT,) * 6
        return self._alarm if faults.saturated or self._beyond else 0, self._counts

    def _loads(self, times_s: Sequence[float]) -> list[Sequence[float]]:
        """Six loads in the box's units at each time, before bias."""
        faults = self.faults
        lag_s = faults.lag_s
        wrenches = self._wrenches([max(0.0, time_s - lag_s) for time_s in times_s] if lag_s else times_s)
        if faults.strange:
            wrenches = [faults.felt(wrench, time_s) for wrench, time_s in zip(wrenches, times_s, strict=True)]
        return list(map(self._load, wrenches))

    def _load(self, wrench: Sequence[float]) -> Sequence[float]:
        """The load in the box's units. Of a wrench that stays, the same as of the one before."""
        if wrench is not self._wrench:
            self._wrench, self._of_wrench = wrench, tuple(map(truediv, wrench, self._size)) if any(wrench) else NO_LOAD
        return self._of_wrench

    def _measured(self, stream: _Stream, ticks: range) -> list[tuple[Record, float]]:
        """Records of these internal samples, and their times, s."""
        times_s = [tick / INTERNAL_RATE_HZ for tick in ticks]
        loads = self._loads(times_s)
        self._skipped, self.faults.skip = self._skipped + self.faults.skip, 0
        number, skipped, records, read = stream.rdt_sequence, self._skipped, [], self._read
        for tick, load, at_s in zip(ticks, loads, times_s, strict=True):
            number = (number + 1) % 2**32
            records.append((Record(number, (tick + skipped) % 2**32, *read(load)), at_s))
        stream.rdt_sequence = number
        return records

    def _send(self, stream: _Stream, time_s: float) -> None:
        self._post.send(b"".join(stream.waiting), time_s, stream.client, self.faults)
        stream.waiting.clear()


def configuration_page(box: RdtBox) -> bytes:
    """netftapi2.xml: the tags of a live box that clients look at, in its order."""
    s = box.settings
    tags: dict[str, object] = {
        "runstat": "0x00000000",
        "runrate": INTERNAL_RATE_HZ,
        "cfgnam": "emulated",
        "cfgcalsel": 0,
        "cfgcalsn": s.serial,
        "scfgfu": s.force_unit,
        "scfgtu": s.torque_unit,
        "cfgcpf": s.counts_per_force,
        "cfgcpt": s.counts_per_torque,
        "cfgmr": ";".join(f"{rating:g}" for rating in s.rating),
        "setcfgsel": 0,
        "setbias": "0;0;0;0;0;0",
        "comrdte": "Enabled",
        "comrdtrate": INTERNAL_RATE_HZ // s.divisor,
        "comrdtbsiz": s.buffer,
    }
    if s.axia:
        tags = {"prodname": "Ethernet Axia"} | tags
    lines = "\n".join(f"<{tag}>{text}</{tag}>" for tag, text in tags.items())
    return f'<?xml version="1.0"?><netft>\n{lines}\n</netft>'.encode("ascii")
