"""Lines that carry bytes: a serial port, or an emulated device in the same process."""

from __future__ import annotations

import contextlib
import errno
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Literal, Protocol, TypeVar

import serial
from serial.tools import list_ports

from emg2vsa.devices.clock import Clock
from emg2vsa.errors import DeviceError

T = TypeVar("T")


class ByteLine(Protocol):
    """Half of a two-way line."""

    name: str

    def write(self, data: bytes) -> None:
        """Send all of ``data``. DeviceError when the line is gone."""

    def read(self, count: int, timeout_s: float) -> bytes:
        """Up to ``count`` bytes, fewer after ``timeout_s``. DeviceError when the line is gone."""

    def drop_input(self) -> None:
        """Throw away what has arrived unread."""

    def close(self) -> None:
        """Give the line back."""


@dataclass
class LineCounts:
    """What has passed over a line so far."""

    requests: int = 0
    lost: int = 0
    "Requests that no good reply followed in time."
    corrupt: int = 0
    "Replies with a wrong checksum."


class SerialLine:
    """A serial port, 8N1, opened exclusively."""

    def __init__(self, port: str, baud: int) -> None:
        self.name = port
        try:
            self._port = serial.Serial(port, baud, timeout=0, write_timeout=0, exclusive=True)
        except (serial.SerialException, ValueError, OSError) as error:
            raise _not_opened(port, error) from error
        # an FTDI bridge otherwise holds bytes back for 16 ms; a virtual port cannot and need not
        with contextlib.suppress(AttributeError, RuntimeError, ValueError, OSError):
            self._port.set_low_latency_mode(True)
        self._shut_others_out(True)

    def write(self, data: bytes) -> None:
        """As `ByteLine`, and never waits: a port that does not take a frame at once is held up. DeviceError tells
        that."""

        def put() -> None:
            # pyserial waits on POSIX even where no wait is allowed
            written = os.write(self._port.fileno(), data) if os.name == "posix" else self._port.write(data)
            if written < len(data):
                raise OSError(errno.EAGAIN, f"the port took {written} of {len(data)} bytes")

        self._guard(put)

    def read(self, count: int, timeout_s: float) -> bytes:
        """As `ByteLine`: up to ``count`` bytes, waiting ``timeout_s`` (s) at most. DeviceError : the port is gone."""

        def take() -> bytes:
            self._port.timeout = timeout_s
            return bytes(self._port.read(count))

        return self._guard(take)

    def drop_input(self) -> None:
        """Forget what has come. DeviceError : the port is gone."""
        # not reset_input_buffer: on a port that is gone it raises termios.error, known to no other system
        self._guard(lambda: self._port.read(self._port.in_waiting) if self._port.in_waiting else b"")

    def set_control(self, line: Literal["dtr", "rts"], high: bool) -> None:
        """Raise or lower a control line of the port. DeviceError when it has none, or is gone."""
        self._guard(lambda: setattr(self._port, line, high))

    def close(self) -> None:
        self._shut_others_out(False)
        self._port.close()

    def _shut_others_out(self, shut: bool) -> None:
        """No other program can open the port, also one that asks for no lock; but one of the superuser."""
        if sys.platform == "win32":
            return
        termios = import_module("termios")
        # a pseudo-terminal would stay shut after a program that was killed
        with contextlib.suppress(OSError, ValueError, AttributeError, termios.error):
            file = self._port.fileno()
            if not os.ttyname(file).startswith("/dev/pts/"):
                import_module("fcntl").ioctl(file, termios.TIOCEXCL if shut else termios.TIOCNXCL)

    def _guard(self, action: Callable[[], T]) -> T:
        try:
            return action()
        except (serial.SerialException, OSError) as error:
            raise DeviceError(
                self.name, wanted="a line that answers", found=str(error), do="Check the cable."
            ) from error


def adapter_number(port: str) -> str:
    """Serial number of the USB adapter behind a port; empty where it has none, or the port is no adapter's."""
    place = os.path.realpath(port)
    found = (each.serial_number for each in list_ports.comports() if os.path.realpath(each.device) == place)
    return next(found, None) or ""


def _not_opened(port: str, error: Exception) -> DeviceError:
    if getattr(error, "errno", None) in (errno.EAGAIN, errno.EBUSY):
        found, do = "one that another program uses", "End that program, perhaps another emg2vsa rig."
        return DeviceError(port, wanted="a free serial port", found=found, do=do)
    do = "Check cable, power and permission, or the port's name."
    return DeviceError(port, wanted="a serial port", found=str(error), do=do)


class LoopbackLine:
    """A line to a device emulated in this process: what is written is answered at once, on the emulator's clock.

    Waiting in vain takes its time on ``clock``; without one it takes none.
    """

    def __init__(self, name: str, device: Callable[[bytes], bytes], clock: Clock | None = None) -> None:
        self.name = name
        self._device, self._clock = device, clock
        self._unread = bytearray()

    def write(self, data: bytes) -> None:
        self._unread += self._device(data)

    def read(self, count: int, timeout_s: float) -> bytes:
        """As `ByteLine`: up to ``count`` bytes; where fewer are there, ``timeout_s`` (s) pass on the clock."""
        taken = bytes(self._unread[:count])
        del self._unread[:count]
        if len(taken) < count and self._clock:
            self._clock.sleep_until(self._clock.now_s() + timeout_s)
        return taken

    def drop_input(self) -> None:
        self._unread.clear()

    def close(self) -> None:
        self._unread.clear()
