"""What a fault of an emulated device is, and the faults of any actuator's wire: bytes lost or changed on either way,
commands that do not arrive, answers that come late, twice or under another id, silence, a loss of power."""

from __future__ import annotations

import math
import random
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import partial
from typing import TYPE_CHECKING, Any, Literal, Protocol

from emg2vsa.devices.clock import Clock
from emg2vsa.devices.serial_line import LoopbackLine

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Way = Literal["to device", "to host"]
Spoil = Callable[[bytes], bytes]
Strike = Callable[[Any, float], None]
"""What a fault does to the bench with a number."""
Action = Callable[[], None]
_FLOOD_BYTES, _FLOOD_BYTES_PER_S = 64, 200_000
"""Bytes that flood at once, and bytes a second of a line of 2 Mbaud."""


@dataclass(frozen=True)
class Fault:
    """What goes wrong, in words, and how.

    words : N stands for the number. strike : puts it on with a number, or off with ``neutral``.
    kind : count, it strikes so many times; switch, on or off; amount, so much until it is off.
    usual : the number when none is given. least, most : bounds of an amount.
    """

    words: str
    strike: Strike
    kind: Literal["count", "switch", "amount"] = "count"
    usual: float = 1
    neutral: float = 0
    least: float = -math.inf
    most: float = math.inf

    @property
    def lasts(self) -> bool:
        """The fault lasts until it is put off."""
        return self.kind != "count"


def switch(name: str, words: str) -> Any:
    """Field of a dataclass of faults: on or off. name : that is typed. words : as of `Fault`."""
    return _field(name, False, bool, words=words, kind="switch")


def count(name: str, words: str) -> Any:
    """So many times; as `switch`."""
    return _field(name, 0, int, words=words)


def amount(
    name: str, words: str, usual: float, neutral: float, least: float = -math.inf, most: float = math.inf,
    made: Callable[[float], object] = float,
) -> Any:  # fmt: skip
    """So much; as `switch`. made : what the field holds of a number."""
    told = {"words": words, "usual": usual, "neutral": neutral, "least": least, "most": most}
    return _field(name, made(neutral), made, kind="amount", **told)


def _field(name: str, default: object, made: Callable[[float], object], **told: object) -> Any:
    return field(default=default, metadata={"name": name, "made": made, "told": told})


def faults_in(part: str, faults: type[DataclassInstance]) -> dict[str, Fault]:
    """Faults by the name that is typed: the fields of a dataclass that are faults. part : of the bench, that holds
    one.
    """
    return {
        each.metadata["name"]: Fault(strike=of_part(part, each.name, each.metadata["made"]), **each.metadata["told"])
        for each in fields(faults)
        if each.metadata
    }


def of_part(part: str, name: str, kind: Callable[[float], object] = bool) -> Strike:
    """Sets an attribute of a part of the bench, as ``box.faults``, to the number as ``kind`` makes it."""

    def strike(bench: Any, value: float) -> None:
        for step in part.split("."):
            bench = getattr(bench, step)
        setattr(bench, name, kind(value))

    return strike


class FaultPlan:
    """Actions that wait for a time, or for a force on the specimen; each is carried out once."""

    def __init__(self) -> None:
        self._at_times: list[tuple[float, Action]] = []
        self._at_forces: list[tuple[float, Action]] = []

    def at_time(self, time_s: float, action: Action) -> None:
        """Once the clock shows ``time_s``, s."""
        self._at_times.append((time_s, action))

    def at_force(self, force_n: float, action: Action) -> None:
        """The fault begins as soon as the true force on the specimen is ``force_n``, N, or more."""
        self._at_forces.append((force_n, action))

    def clear(self) -> None:
        """Nothing is to happen any more."""
        self._at_times.clear()
        self._at_forces.clear()

    def look(self, now_s: float, force_n: Callable[[float], float]) -> None:
        """Carry out what is due at the clock's time; ``force_n`` tells the force at a time."""
        if not (self._at_times or self._at_forces):
            return
        reached = force_n(now_s) if self._at_forces else 0.0
        for waiting, until in ((self._at_times, now_s), (self._at_forces, reached)):
            for each in [each for each in waiting if each[0] <= until]:
                waiting.remove(each)
                each[1]()  # which may plan its own end


def thousandth(value: float) -> float:
    """A thousandth of a number, of milliseconds or the like."""
    return value / 1000


def percent(value: float) -> float:
    """A number of percent as a share."""
    return value / 100


def finite(value: float) -> float | None:
    """None where there is no bound."""
    return value if math.isfinite(value) else None


class Frames(Protocol):
    """What a fault must know of an actuator's packets."""

    @property
    def position_commands(self) -> frozenset[int]:
        """Commands that tell the motor where to go."""

    @property
    def watchdog_commands(self) -> frozenset[int]:
        """Commands that set the watchdog."""

    def without(self, data: bytes, commands: frozenset[int]) -> bytes:
        """``data`` but for the packets of ``commands``; what is no whole packet stays as it is."""

    def renamed(self, data: bytes, shift: int) -> bytes:
        """An answer under another id, which is not found out by its checksum."""


class Device(Protocol):
    """The far end of a line."""

    def __call__(self, data: bytes) -> bytes: ...

    def reset(self) -> None: ...

    @property
    def due_s(self) -> float:
        """When the next answer comes that is on its way, s; inf for none."""


class FaultyWire:
    """A device behind a wire that fails when told to. Each fault strikes the next bytes of its way, once.

    ``clock`` is needed for answers that come late, ``seed`` for bytes that are lost or wrong by chance.
    """

    def __init__(self, device: Device, frames: Frames, clock: Clock | None = None, seed: int = 0) -> None:
        self._device, self.frames, self._clock = device, frames, clock
        self._chance = random.Random(seed)
        self._faults: list[tuple[Way, Spoil]] = []
        self._coming: deque[tuple[float, bytes]] = deque()
        self.mute = self.deaf = self.noisy = self.doubled = self.flooded = False
        """While True: mute, the device hears but nothing of it comes back; deaf, nothing reaches it; noisy, one byte of
        every answer is wrong; doubled, every answer comes twice; flooded, random bytes without an end come in place of
        answers."""
        self.ignored: frozenset[int] = frozenset()
        "Commands of which no frame reaches the device, while all others do."
        self.id_shift = 0
        "Added to the id of every answer."
        self._flood_s = 0.0
        "When more of it comes."
        self.late_s = self.lost_share = self.wrong_share = 0.0
        "How late answers come; which share of the bytes of both ways gets lost, or has a wrong bit."

    def __call__(self, data: bytes) -> bytes:
        if not self._failing:
            return self._device(data)
        heard = b"" if self.deaf else self._carry("to device", data)
        if self.ignored:
            heard = self.frames.without(heard, self.ignored)
        answer = self._carry("to host", self._device(heard))
        if self.noisy:
            answer = answer[:-1] + bytes(byte ^ 1 for byte in answer[-1:])
        if self.id_shift:
            answer = self.frames.renamed(answer, self.id_shift)
        if self.doubled:
            answer += answer
        if self.mute:
            answer = b""
        if self._clock is None:
            return answer
        now_s = self._clock.now_s()
        if self.flooded:
            self._flood_s = now_s + _FLOOD_BYTES / _FLOOD_BYTES_PER_S
            return self._chance.randbytes(_FLOOD_BYTES)
        if answer:
            self._coming.append((now_s + self.late_s, answer))
        arrived = b""
        while self._coming and self._coming[0][0] <= now_s:
            arrived += self._coming.popleft()[1]
        return arrived

    @property
    def _failing(self) -> bool:
        return bool(
            self._faults or self._coming or self.deaf or self.mute or self.noisy or self.doubled or self.ignored
            or self.flooded or self.id_shift or self.late_s or self.lost_share or self.wrong_share
        )  # fmt: skip

    @property
    def due_s(self) -> float:
        """When the next late answer comes, s, or more of a flood; inf when none is on its way."""
        if self.flooded:
            return self._flood_s
        own_s = self._coming[0][0] if self._coming else math.inf
        return min(own_s, self._device.due_s)

    def lose(self, way: Way, at: int, count: int = 1) -> None:
        """Drop ``count`` bytes from the index ``at`` on, which may be negative."""
        self._faults.append((way, lambda data: data[:at] + data[at:][count:]))

    def corrupt(self, way: Way, at: int, mask: int = 0xFF) -> None:
        """Turn the bits of ``mask`` in one byte, so far as there is one."""

        def spoil(data: bytes) -> bytes:
            return data[:at] + bytes(byte ^ mask for byte in data[at:][:1]) + data[at:][1:]

        self._faults.append((way, spoil))

    def reset(self) -> None:
        """Power off and on."""
        self._device.reset()

    def _carry(self, way: Way, data: bytes) -> bytes:
        if self.lost_share:
            data = bytes(byte for byte in data if self._chance.random() >= self.lost_share)
        if self.wrong_share:
            data = bytes(byte ^ self._wrong_bit() for byte in data)
        struck = next((fault for fault in self._faults if fault[0] == way), None) if data else None
        if struck is None:
            return data
        self._faults.remove(struck)
        return struck[1](data)

    def _wrong_bit(self) -> int:
        return 1 << self._chance.randrange(8) if self._chance.random() < self.wrong_share else 0


class WireLine(LoopbackLine):
    """A line within this process that also waits for answers which come late.

    ``device`` is what bytes are given to, ``due_s`` tells when its next late answer comes."""

    def __init__(self, name: str, device: Callable[[bytes], bytes], due_s: Callable[[], float], clock: Clock) -> None:
        super().__init__(name, device, clock)
        self._ask, self._due_s, self._time = device, due_s, clock

    def read(self, count: int, timeout_s: float) -> bytes:
        """Up to ``count`` bytes, those included that come within ``timeout_s``, s."""
        end_s = self._time.now_s() + timeout_s
        while len(self._unread) < count and (due_s := self._due_s()) <= end_s:
            self._time.sleep_until(due_s)
            self._unread += self._ask(b"")
        return super().read(count, max(0.0, end_s - self._time.now_s()))


def _lose(bench: Any, count: float) -> None:
    bench.wire.lose("to host", at=-int(count), count=int(count))


def _corrupt(bench: Any, count: float) -> None:
    for _ in range(int(count)):
        bench.wire.corrupt("to host", at=-1)


def _ignore(which: str) -> Strike:
    def strike(bench: Any, on: float) -> None:
        commands = getattr(bench.wire.frames, which)
        bench.wire.ignored = bench.wire.ignored | commands if on else bench.wire.ignored - commands

    return strike


_of_wire = partial(of_part, "wire")
WIRE_FAULTS = {
    "lose": Fault("the next reply of the actuator lacks its last N bytes", _lose),
    "corrupt": Fault("the next N replies of the actuator have a wrong byte", _corrupt),
    "reset": Fault("the actuator's power goes off and on", lambda bench, _: bench.reset_actuator()),
    "mute": Fault("the actuator hears but does not answer", _of_wire("mute"), "switch"),
    "deaf": Fault("the actuator hears nothing", _of_wire("deaf"), "switch"),
    "ignore": Fault("no position command reaches the actuator, all else does", _ignore("position_commands"), "switch"),
    "no-watchdog": Fault("no command of the watchdog reaches the actuator", _ignore("watchdog_commands"), "switch"),
    "late": Fault("replies of the actuator come N ms late", _of_wire("late_s", thousandth), "amount", 4, 0, 0, 1000),
    "bytes-lost": Fault(
        "N % of the bytes of both ways are lost", _of_wire("lost_share", percent), "amount", 1, 0, 0, 100
    ),
    "bits-wrong": Fault(
        "N % of the bytes of both ways have a wrong bit", _of_wire("wrong_share", percent), "amount", 1, 0, 0, 100
    ),
    "doubled": Fault("every reply of the actuator comes twice", _of_wire("doubled"), "switch"),
    "flood": Fault("random bytes without an end come in place of replies", _of_wire("flooded"), "switch"),
    "stranger": Fault("the actuator answers with the next id", _of_wire("id_shift", int), "switch"),
}
"""By the name that is typed."""
