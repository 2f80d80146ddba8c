"""Lines that carry datagrams: UDP, or an emulated device in the same process."""

from __future__ import annotations

import socket
import struct
import sys
import time
from collections import deque
from collections.abc import Callable
from typing import NamedTuple, Protocol

from emg2vsa.devices.clock import Clock
from emg2vsa.errors import DeviceError


class Datagram(NamedTuple):
    """What arrived, and how long ago, s."""

    data: bytes
    age_s: float


class DatagramLine(Protocol):
    """One end of a line that carries datagrams."""

    name: str

    def send(self, data: bytes) -> None:
        """Send one datagram. DeviceError when the line is gone."""

    def receive(self) -> Datagram | None:
        """The oldest datagram not received yet, None when there is none; never waits. DeviceError when the line is
        gone."""

    def close(self) -> None:
        """Give the line back."""


class UdpLine:
    """UDP to one port of one host.

    On Linux the kernel says when a datagram came, so that one that waited is not taken for a new one; elsewhere its
    age is 0. A step of the computer's clock makes a datagram look older than the moment at which nothing waited; it is
    not, and that moment bounds its age.
    """

    def __init__(self, host: str, port: int) -> None:
        self.name = f"{host}:{port}"
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER_BYTES)
        if sys.platform == "linux":
            self._socket.setsockopt(socket.SOL_SOCKET, _SO_TIMESTAMPNS, 1)
        self._socket.setblocking(False)
        self._guard(lambda: self._socket.connect((host, port)))
        self._empty_s = time.monotonic()
        "When nothing waited here; all that is received since then has come since then."

    def send(self, data: bytes) -> None:
        """Send one datagram. DeviceError : the line is gone."""
        self._guard(lambda: self._socket.send(data))

    def receive(self) -> Datagram | None:
        """The next datagram that has come, or None. DeviceError : the line is gone."""
        try:
            if not hasattr(self._socket, "recvmsg"):
                return Datagram(self._socket.recv(_LARGEST_BYTES), 0.0)
            data, extras, _, _ = self._socket.recvmsg(_LARGEST_BYTES, _EXTRAS_BYTES)
        except BlockingIOError:
            self._empty_s = time.monotonic()
            return None
        except OSError as error:
            raise self._gone(error) from error
        return Datagram(data, min(_age_s(extras), time.monotonic() - self._empty_s))

    def close(self) -> None:
        self._socket.close()

    def _guard(self, action: Callable[[], object]) -> None:
        try:
            action()
        except OSError as error:
            raise self._gone(error) from error

    def _gone(self, error: OSError) -> DeviceError:
        found, do = error.strerror or str(error), "Check address, cable and power."
        return DeviceError(self.name, wanted="a device that answers", found=found, do=do)


class DatagramDevice(Protocol):
    """An emulated device: takes requests, and sends by itself as time goes on."""

    def request(self, data: bytes, client: Callable[[bytes, float], None], time_s: float) -> None:
        """A datagram came; ``client`` is called with every datagram for its sender and the time it was sent."""

    def run_until(self, time_s: float) -> None:
        """Send everything that is due by ``time_s``, s."""


class LoopbackDatagrams:
    """A line to a device emulated in this process, which lives on ``clock``."""

    def __init__(self, name: str, device: DatagramDevice, clock: Clock) -> None:
        self.name = name
        self._device, self._clock = device, clock
        self._unread: deque[tuple[bytes, float]] = deque()

    def send(self, data: bytes) -> None:
        self._device.request(data, self._deliver, self._clock.now_s())

    def receive(self) -> Datagram | None:
        now_s = self._clock.now_s()
        self._device.run_until(now_s)
        if not self._unread:
            return None
        data, sent_s = self._unread.popleft()
        return Datagram(data, now_s - sent_s)

    def close(self) -> None:
        self._unread.clear()

    def _deliver(self, data: bytes, time_s: float) -> None:
        self._unread.append((data, time_s))


def _age_s(extras: list[tuple[int, int, bytes]]) -> float:
    for level, kind, data in extras:
        if (level, kind) == (socket.SOL_SOCKET, _SO_TIMESTAMPNS):
            seconds, nanoseconds = _TIMESPEC.unpack(data)
            age_ns: int = time.time_ns() - seconds * 1_000_000_000 - nanoseconds
            return max(0.0, age_ns * 1e-9)
    return 0.0


# linux/asm-generic/socket.h; the socket module does not name it
_SO_TIMESTAMPNS = 35
_TIMESPEC = struct.Struct("@ll")
_BUFFER_BYTES = 1 << 20
_LARGEST_BYTES = 2048
_EXTRAS_BYTES = 64
