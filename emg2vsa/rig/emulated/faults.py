"""Faults on a line, on demand: bytes lost or changed on either way, a device that falls silent or loses power."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol

Way = Literal["to device", "to host"]
Spoil = Callable[[bytes], bytes]


class Device(Protocol):
    """The far end of a line."""

    def __call__(self, data: bytes) -> bytes: ...

    def reset(self) -> None: ...


@dataclass(frozen=True)
class _Fault:
    way: Way
    spoil: Spoil


class FaultyWire:
    """A device behind a wire that fails when told to. Each fault strikes the next bytes of its way, once."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._faults: list[_Fault] = []
        self.mute = self.deaf = self.noisy = False
        """While True: mute, the device hears but nothing of it comes back; deaf, nothing reaches it; noisy, one byte of
        every answer is wrong."""

    def __call__(self, data: bytes) -> bytes:
        answer = self._carry("to host", self._device(b"" if self.deaf else self._carry("to device", data)))
        if self.noisy:
            answer = answer[:-1] + bytes(byte ^ 1 for byte in answer[-1:])
        return b"" if self.mute else answer

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
        struck = next((fault for fault in self._faults if fault.way == way), None) if data else None
        if struck is None:
            return data
        self._faults.remove(struck)
        return struck.spoil(data)
