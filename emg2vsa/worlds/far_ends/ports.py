"""What emulated devices that others open are made of: threads within a with statement, a pseudo-terminal, a page."""

from __future__ import annotations

import contextlib
import math
import os
import select
import sys
import threading
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Self

from emg2vsa.errors import SettingError

if sys.platform != "win32":
    import pty
    import tty

HOST = "127.0.0.1"
IDLE_S = 0.05
"Longest wait before a server looks whether it shall end."
_CHUNK_BYTES = 4096


class Serving:
    """Loops that run in threads of their own within a with statement. Each ends soon after ``_ended`` is set."""

    def __init__(self, *loops: Callable[[], object], name: str) -> None:
        self._ended = threading.Event()
        self._threads = [threading.Thread(target=loop, name=name, daemon=True) for loop in loops]

    def __enter__(self) -> Self:
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._ended.set()
        for thread in self._threads:
            thread.join()
        self._close()

    def _close(self) -> None:
        """Give back what was opened."""


class VirtualSerialPort(Serving):
    """A pseudo-terminal and the thread that answers on it. ``name`` is the port to open."""

    def __init__(self, device: Callable[[bytes], bytes], waits_s: Callable[[], float] = lambda: math.inf) -> None:
        """``device`` is called from the thread, one call at a time; without bytes when an answer that is late has come,
        as ``waits_s`` tells."""
        self._device, self._waits_s = device, waits_s
        self._device_end, self._host_end, self.name = _pseudo_terminal()
        super().__init__(self._answer, name=f"device at {self.name}")

    def _answer(self) -> None:
        while not self._ended.is_set():
            asked = select.select([self._device_end], [], [], max(0.0, min(IDLE_S, self._waits_s())))[0]
            if asked or self._waits_s() <= 0:
                answer = self._device(os.read(self._device_end, _CHUNK_BYTES) if asked else b"")
                # a host that does not read must not hold up the end of this thread
                while answer and not self._ended.is_set():
                    if select.select([], [self._device_end], [], IDLE_S)[1]:
                        answer = answer[os.write(self._device_end, answer) :]

    def _close(self) -> None:
        # the host's end stays open until here, so that clients may come and go
        for end in (self._host_end, self._device_end):
            with contextlib.suppress(OSError):
                os.close(end)


def _pseudo_terminal() -> tuple[int, int, str]:
    """The device's end, the host's end, and the name of the port. SettingError on Windows, which has none."""
    if sys.platform != "win32":
        device_end, host_end = pty.openpty()
        tty.setraw(host_end)
        os.set_blocking(device_end, False)
        return device_end, host_end, os.ttyname(host_end)
    do = "Use emg2vsa rig run --virtual."
    raise SettingError("rig emulate", wanted="a system with virtual serial ports", found="Windows", do=do)


class Page:
    """One page of HTTP on the loopback, written by ``write``; OSError where the port is taken. ``port`` 0 is any."""

    def __init__(self, port: int, path: str, write: Callable[[BaseHTTPRequestHandler], None]) -> None:
        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                if self.path.partition("?")[0] == path:
                    write(self)
                else:
                    self.send_error(404)

            def log_message(self, format: str, *args: object) -> None:
                """Nobody keeps a log of who reads."""

        self._http = ThreadingHTTPServer((HOST, port), Handler)
        self._http.timeout = IDLE_S
        self.port: int = self._http.server_address[1]

    def serve(self, ended: threading.Event) -> None:
        """Until that."""
        while not ended.is_set():
            self._http.handle_request()
        self._http.server_close()
