"""Lines that carry bytes: a serial port, or an emulated device in the same process."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypeVar

import serial

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


class SerialLine:
    """A serial port, 8N1, opened exclusively."""

    def __init__(self, port: str, baud: int) -> None:
        self.name = port
        try:
            self._port = serial.Serial(port, baud, timeout=0, write_timeout=1.0, exclusive=True)
        except (serial.SerialException, ValueError, OSError) as error:
            raise DeviceError(
                port,
                wanted="a serial port",
                found=str(error),
                do="Check cable, power and permission, or the port's name.",
            ) from error

    def write(self, data: bytes) -> None:
        self._guard(lambda: self._port.write(data))

    def read(self, count: int, timeout_s: float) -> bytes:
        def take() -> bytes:
            self._port.timeout = timeout_s
            return bytes(self._port.read(count))

        return self._guard(take)

    def drop_input(self) -> None:
        self._guard(self._port.reset_input_buffer)

    def close(self) -> None:
        self._port.close()

    def _guard(self, action: Callable[[], T]) -> T:
        try:
            return action()
        except (serial.SerialException, OSError) as error:
            raise DeviceError(
                self.name, wanted="a line that answers", found=str(error), do="Check the cable."
            ) from error


class LoopbackLine:
    """A line to a device emulated in this process: what is written is answered at once, on the emulator's clock."""

    def __init__(self, name: str, device: Callable[[bytes], bytes]) -> None:
        self.name = name
        self._device = device
        self._unread = bytearray()

    def write(self, data: bytes) -> None:
        self._unread += self._device(data)

    def read(self, count: int, timeout_s: float) -> bytes:
        taken = bytes(self._unread[:count])
        del self._unread[:count]
        return taken

    def drop_input(self) -> None:
        self._unread.clear()

    def close(self) -> None:
        self._unread.clear()
