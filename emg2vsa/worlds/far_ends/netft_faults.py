"""What goes wrong in an emulated force sensor: loads felt wrongly, and datagrams lost, late, doubled or strange."""

from __future__ import annotations

import math
import random
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field

from emg2vsa.devices.netft.box import Record, record_bytes

Client = Callable[[bytes, float], None]
_SEQUENCE_BYTES = 4
_ROUNDING_S = 1e-9


@dataclass
class BoxFaults:
    """What goes wrong, changed while the box runs. The axis that fails is z, along which a rig pushes unless told else.

    lose, repeat, swap : the next so many datagrams are lost, sent twice, or sent after the one that follows.
    skip : the box leaves out so many internal samples once, without a gap in rdt_sequence.
    trash : the next so many datagrams are followed by one of the right length full of random numbers.
    mute : sends nothing. stuck : the counts stay. saturated : the status says so. overflow : the largest counts, under
    a good status.
    push_n : somebody leans on the sensor, N along z. drift_n_per_s : z drifts, from ``drifts_from_s`` on.
    swapped : x and z are exchanged. dead : z gives its noise only. turned : z has the wrong sign.
    gain : of all six. lag_s : loads are those of so long ago, in records that come in time.
    late_s : datagrams come so late. thinned : share of datagrams lost. doubled : each comes twice.
    shuffled : of so many datagrams the oldest comes last, again and again.
    garbage : each datagram is followed by one with its counts and a random rdt_sequence.
    cut : datagrams lack their last byte. replayed : one datagram again and again.
    seed : of what is random.
    """

    lose: int = 0
    repeat: int = 0
    swap: int = 0
    skip: int = 0
    trash: int = 0
    mute: bool = False
    stuck: bool = False
    saturated: bool = False
    overflow: bool = False
    push_n: float = 0.0
    drift_n_per_s: float = 0.0
    drifts_from_s: float = 0.0
    swapped: bool = False
    dead: bool = False
    turned: bool = False
    gain: float = 1.0
    lag_s: float = 0.0
    late_s: float = 0.0
    thinned: float = 0.0
    doubled: bool = False
    shuffled: int = 0
    garbage: bool = False
    cut: bool = False
    replayed: bool = False
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
        """When the next late datagram comes; inf without one."""
        return self._late[0][0] if self._late else math.inf

    def forget(self) -> None:
        """Another stream begins."""
        self._held: bytes | None = None
        self._passed = 0
        self._late.clear()

    def send(self, data: bytes, time_s: float, client: Client, faults: BoxFaults) -> None:
        """One datagram, or what becomes of it."""
        self._replayed = (self._replayed or data) if faults.replayed else None
        for each in self._spoilt(self._replayed or data, faults):
            if faults.late_s or self._late:
                self._late.append((time_s + faults.late_s, each, client))
            else:
                client(each, time_s)

    def deliver(self, until_s: float) -> None:
        """Everything late that has arrived by then."""
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
        if self._held is None and (faults.swap or faults.shuffled):
            self._held, self._passed = data, 0
            return
        yield from _copies(data, faults)
        self._passed += 1
        if self._held is not None and self._passed >= faults.shuffled - 1:
            yield self._held
            self._held, faults.swap = None, max(0, faults.swap - 1)


def _copies(data: bytes, faults: BoxFaults) -> Iterator[bytes]:
    data = data[:-1] if faults.cut else data
    yield data
    if faults.doubled or faults.repeat:
        faults.repeat = max(0, faults.repeat - 1)
        yield data
    if faults.garbage:
        yield faults.chance.randbytes(_SEQUENCE_BYTES) + data[_SEQUENCE_BYTES:]
    if faults.trash:
        faults.trash -= 1
        counts = [faults.chance.randrange(-(2**31), 2**31) for _ in range(6)]
        yield record_bytes(Record(faults.chance.randrange(2**32), 0, 0, tuple(counts)))
