"""What goes wrong in an emulated force sensor: loads felt wrongly, and datagrams lost, late, doubled or strange."""

from __future__ import annotations

import math
import random
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field

from emg2vsa.devices.netft.box import Record, record_bytes
from emg2vsa.worlds.far_ends.faults import amount, count, percent, switch, thousandth

Client = Callable[[bytes, float], None]
_SEQUENCE_BYTES = 4
_ROUNDING_S = 1e-9


@dataclass
class BoxFaults:
    """What goes wrong, changed while the box runs. The axis that fails is z, along which a rig pushes unless told else.

    skip : once, without a gap in rdt_sequence. garbage : with the counts of the datagram before it. saturated : by the
    status. overflow : under a good status. lag_s : in records that come in time. drifts_from_s : when a drift began.
    seed : of what is random.
    """

    lose: int = count("gap", "the next N datagrams of the force sensor are lost")
    skip: int = count("skip", "the force sensor leaves out N internal samples")
    trash: int = count("trash", "the next N datagrams are each followed by one of random numbers")
    garbage: bool = switch("garbage", "every datagram is followed by one of a random sequence")
    swamped: bool = switch("swamp", "a hundred datagrams of random bytes follow each of the force sensor")
    thinned: float = amount("thinned", "N % of the datagrams are lost", 50, 0, 0, 100, percent)
    doubled: bool = switch("twice", "every datagram comes twice")
    shuffled: int = amount("shuffled", "of N datagrams the oldest comes last", 4, 0, 2, 100, int)
    late_s: float = amount("delayed", "datagrams come N ms late", 20, 0, 0, 1000, thousandth)
    lag_s: float = amount("lag", "the force is that of N ms ago", 20, 0, 0, 1000, thousandth)
    cut: bool = switch("cut", "datagrams lack their last byte")
    replayed: bool = switch("replayed", "the same datagram comes again and again")
    stuck: bool = switch("stuck", "the force stays as it is")
    saturated: bool = switch("saturated", "the force sensor says that it is saturated")
    overflow: bool = switch("overflow", "the force sensor sends its largest counts")
    mute: bool = switch("silent", "the force sensor sends nothing")
    swapped: bool = switch("swapped", "x and z of the force sensor are exchanged")
    turned: bool = switch("turned", "z of the force sensor has the wrong sign")
    dead: bool = switch("dead", "z of the force sensor gives its noise only")
    gain: float = amount("gain", "the force sensor gives N times the load", 0.2, 1, -100, 100)
    drift_n_per_s: float = amount("drift", "z of the force sensor drifts by N N/s", -2, 0, -1000, 1000)
    push_n: float = amount("push", "somebody leans on the force sensor with N N", 2, 0, -1000, 1000)
    drifts_from_s: float = 0.0
    seed: int = 0
    chance: random.Random = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self.chance = random.Random(self.seed)

    @property
    def strange(self) -> bool:
        """Whether the sensor takes a load for another."""
        pushed = self.push_n or self.drift_n_per_s
        return bool(pushed or self.swapped or self.dead or self.turned or self.gain != 1.0)

    def felt(self, wrench: Iterable[float], time_s: float) -> list[float]:
        """Force, N, and torque, N m, as the sensor takes them."""
        x, y, z, *torque = wrench
        if self.swapped:
            x, z = z, x
        z = 0.0 if self.dead else -z if self.turned else z
        z += self.push_n + self.drift_n_per_s * (time_s - self.drifts_from_s)
        return [self.gain * part for part in (x, y, z, *torque)]


class FaultyPost:
    """The way of datagrams from the box to its client."""

    def __init__(self) -> None:
        self._late: deque[tuple[float, bytes, Client]] = deque()
        self._replayed: bytes | None = None
        self.forget()

    @property
    def due_s(self) -> float:
        """When the next late datagram comes, s; inf without one."""
        return self._late[0][0] if self._late else math.inf

    def forget(self) -> None:
        """Another stream begins."""
        self._held: bytes | None = None
        self._passed = 0
        self._late.clear()

    def send(self, data: bytes, time_s: float, client: Client, faults: BoxFaults) -> None:
        """One datagram, sent at ``time_s``, s, or what becomes of it."""
        self._replayed = (self._replayed or data) if faults.replayed else None
        for each in self._spoilt(self._replayed or data, faults):
            if faults.late_s or self._late:
                self._late.append((time_s + faults.late_s, each, client))
            else:
                client(each, time_s)

    def deliver(self, until_s: float) -> None:
        """Everything late that has arrived by ``until_s``, s."""
        while self._late and self._late[0][0] <= until_s + _ROUNDING_S:
            due_s, data, client = self._late.popleft()
            client(data, due_s)

    def _spoilt(self, data: bytes, faults: BoxFaults) -> Iterator[bytes]:
        if faults.mute:
            return
        if faults.lose:
            faults.lose -= 1
            return
        if faults.thinned and faults.chance.random() < faults.thinned:
            return
        if self._held is None and faults.shuffled:
            self._held, self._passed = data, 0
            return
        yield from _copies(data, faults)
        self._passed += 1
        if self._held is not None and self._passed >= faults.shuffled - 1:
            yield self._held
            self._held = None


def _copies(data: bytes, faults: BoxFaults) -> Iterator[bytes]:
    data = data[:-1] if faults.cut else data
    yield data
    if faults.doubled:
        yield data
    if faults.garbage:
        yield faults.chance.randbytes(_SEQUENCE_BYTES) + data[_SEQUENCE_BYTES:]
    if faults.swamped:
        yield from (faults.chance.randbytes(len(data)) for _ in range(100))
    if faults.trash:
        faults.trash -= 1
        counts = [faults.chance.randrange(-(2**31), 2**31) for _ in range(6)]
        yield record_bytes(Record(faults.chance.randrange(2**32), 0, 0, tuple(counts)))
