"""Faults on a line, on demand: bytes lost or changed on either way, commands that do not arrive, answers that come
late, twice or under another id, a device that falls silent or loses power."""

from __future__ import annotations

import math
import random
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol

from emg2vsa.devices.clock import Clock
from emg2vsa.devices.serial_line import LoopbackLine

Way = Literal["to device", "to host"]
Spoil = Callable[[bytes], bytes]


class Frames(Protocol):
    """What a fault must know of an actuator's packets."""

    @property
    def position_commands(self) -> frozenset[int]:
        """That tell it where to go."""

    @property
    def watchdog_commands(self) -> frozenset[int]:
        """That set its watchdog."""

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
        """When the next answer comes that is on its way; inf for none."""


@dataclass(frozen=True)
class _Fault:
    way: Way
    spoil: Spoil


class FaultyWire:
    """A device behind a wire that fails when told to. Each fault strikes the next bytes of its way, once.

    ``clock`` is needed for answers that come late, ``seed`` for bytes that are lost or wrong by chance.
    """

    def __init__(self, device: Device, frames: Frames, clock: Clock | None = None, seed: int = 0) -> None:
        self._device, self.frames, self._clock = device, frames, clock
        self._chance = random.Random(seed)
        self._faults: list[_Fault] = []
        self._coming: deque[tuple[float, bytes]] = deque()
        self.mute = self.deaf = self.noisy = self.doubled = False
        """While True: mute, the device hears but nothing of it comes back; deaf, nothing reaches it; noisy, one byte of
        every answer is wrong; doubled, every answer comes twice."""
        self.ignored: frozenset[int] = frozenset()
        "Commands of which no frame reaches the device, while all others do."
        self.id_shift = 0
        "Added to the id of every answer."
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
            or self.id_shift or self.late_s or self.lost_share or self.wrong_share
        )  # fmt: skip

    @property
    def due_s(self) -> float:
        """When the next late answer comes; inf when none is on its way."""
        own_s = self._coming[0][0] if self._coming else math.inf
        return min(own_s, self._device.due_s)

    def lose(self, way: Way, at: int, count: int = 1) -> None:
        """Drop ``count`` bytes from the index ``at`` on, which may be negative."""
        self._faults.append(_Fault(way, lambda data: data[:at] + data[at:][count:]))

    def corrupt(self, way: Way, at: int, mask: int = 0xFF) -> None:
        """Turn the bits of ``mask`` in one byte, so far as there is one."""

        def spoil(data: bytes) -> bytes:
            return data[:at] + bytes(byte ^ mask for byte in data[at:][:1]) + data[at:][1:]

        self._faults.append(_Fault(way, spoil))

    def reset(self) -> None:
        """Power off and on."""
        self._device.reset()

    def _carry(self, way: Way, data: bytes) -> bytes:
        if self.lost_share:
            data = bytes(byte for byte in data if self._chance.random() >= self.lost_share)
        if self.wrong_share:
            data = bytes(byte ^ self._wrong_bit() for byte in data)
        struck = next((fault for fault in self._faults if fault.way == way), None) if data else None
        if struck is None:
            return data
        self._faults.remove(struck)
        return struck.spoil(data)

    def _wrong_bit(self) -> int:
        return 1 << self._chance.randrange(8) if self._chance.random() < self.wrong_share else 0


class WireLine(LoopbackLine):
    """A line within this process that also waits for answers which come late.

    ``device`` is what bytes are given to, ``due_s`` tells when its next late answer comes."""

    def __init__(self, name: str, device: Callable[[bytes], bytes], due_s: Callable[[], float], clock: Clock) -> None:
        super().__init__(name, device, clock)
        self._ask, self._due_s, self._time = device, due_s, clock

    def read(self, count: int, timeout_s: float) -> bytes:
        end_s = self._time.now_s() + timeout_s
        while len(self._unread) < count and (due_s := self._due_s()) <= end_s:
            self._time.sleep_until(due_s)
            self._unread += self._ask(b"")
        return super().read(count, max(0.0, end_s - self._time.now_s()))
