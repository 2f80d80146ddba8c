"""The emulated rig in real time, at addresses that any program can open: serial port, UDP, HTTP and TCP."""

from __future__ import annotations

import contextlib
import math
import os
import select
import sys
import threading
from collections.abc import Callable
from contextlib import ExitStack
from typing import Self

from emg2vsa.errors import SettingError
from emg2vsa.worlds.bench.bench import EmulatedRig
from emg2vsa.worlds.far_ends.camera.server import CameraServer
from emg2vsa.worlds.far_ends.netft.server import RdtServer

if sys.platform != "win32":
    import pty
    import tty

_LOOK_UP_S = 0.05
_CHUNK_BYTES = 4096


class VirtualSerialPort:
    """A pseudo-terminal and the thread that answers on it. ``name`` is the port to open."""

    def __init__(self, device: Callable[[bytes], bytes], waits_s: Callable[[], float] = lambda: math.inf) -> None:
        """``device`` is called from the thread, one call at a time; without bytes when an answer that is late has come,
        as ``waits_s`` tells."""
        self._device, self._waits_s = device, waits_s
        self._device_end, self._host_end, self.name = _pseudo_terminal()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._serve, name=f"device at {self.name}", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._stop.set()
        self._thread.join()
        # the host's end stays open until here, so that clients may come and go
        for end in (self._host_end, self._device_end):
            with contextlib.suppress(OSError):
                os.close(end)

    def _serve(self) -> None:
        while not self._stop.is_set():
            asked = select.select([self._device_end], [], [], max(0.0, min(_LOOK_UP_S, self._waits_s())))[0]
            if asked or self._waits_s() <= 0:
                answer = self._device(os.read(self._device_end, _CHUNK_BYTES) if asked else b"")
                while answer:
                    answer = answer[os.write(self._device_end, answer) :]


def _pseudo_terminal() -> tuple[int, int, str]:
    """The device's end, the host's end, and the name of the port. SettingError on Windows, which has none."""
    if sys.platform != "win32":
        device_end, host_end = pty.openpty()
        tty.setraw(host_end)
        return device_end, host_end, os.ttyname(host_end)
    do = "Use emg2vsa rig run --virtual."
    raise SettingError("rig emulate", wanted="a system with virtual serial ports", found="Windows", do=do)


class EmulatedServers:
    """Serves ``bench``, which must be on a wall clock, within a with statement.

    port : name of the serial port of the actuator that presses; idle_port : of the other one. force : host and ports of
    the force sensor's box.
    camera_url : where the camera's pictures are.
    """

    def __init__(self, bench: EmulatedRig) -> None:
        self.bench = bench
        self._serial = VirtualSerialPort(bench.answer, lambda: bench.wire.due_s - bench.clock.now_s())
        self.force = RdtServer(bench.box, bench.clock)
        self._camera = CameraServer(bench.camera)
        self._idle = VirtualSerialPort(bench.idle)
        self.port, self.idle_port, self.camera_url = self._serial.name, self._idle.name, self._camera.url
        self._open = ExitStack()

    def __enter__(self) -> Self:
        for server in (self._serial, self._idle, self.force, self._camera):
            self._open.enter_context(server)
        return self

    def __exit__(self, *error: object) -> None:
        self._open.close()
