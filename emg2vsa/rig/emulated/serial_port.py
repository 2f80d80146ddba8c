"""An emulated device behind a port of the operating system, for every program that opens serial ports (POSIX only)."""

from __future__ import annotations

import contextlib
import os
import pty
import select
import threading
import tty
from collections.abc import Callable
from types import TracebackType
from typing import Self

_LOOK_UP_S = 0.05
_CHUNK_BYTES = 4096


class VirtualSerialPort:
    """A pseudo-terminal and the thread that answers on it. ``name`` is the port to open."""

    def __init__(self, device: Callable[[bytes], bytes]) -> None:
        """``device`` is called from the thread, one call at a time."""
        self._device = device
        self._device_end, self._host_end = pty.openpty()
        tty.setraw(self._host_end)
        self.name = os.ttyname(self._host_end)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._serve, name=f"device at {self.name}", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop.set()
        self._thread.join()
        # the host's end stays open until here, so that clients may come and go
        for end in (self._host_end, self._device_end):
            with contextlib.suppress(OSError):
                os.close(end)

    def _serve(self) -> None:
        while not self._stop.is_set():
            if select.select([self._device_end], [], [], _LOOK_UP_S)[0]:
                answer = self._device(os.read(self._device_end, _CHUNK_BYTES))
                while answer:
                    answer = answer[os.write(self._device_end, answer) :]
