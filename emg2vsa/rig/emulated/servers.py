"""The emulated rig in real time, at addresses that any program can open: serial port, UDP, HTTP and TCP."""

from __future__ import annotations

from contextlib import ExitStack
from types import TracebackType
from typing import Self

from emg2vsa.rig.emulated.bench import EmulatedRig
from emg2vsa.rig.emulated.camera_server import CameraServer
from emg2vsa.rig.emulated.rdt_server import RdtServer
from emg2vsa.rig.emulated.serial_port import VirtualSerialPort


class EmulatedServers:
    """Serves ``bench``, which must be on a wall clock, from `start` to `close` or within a with.

    port : name of the serial port of the actuator that presses; idle_port : of the other one. force : host and ports of
    the force sensor's box.
    camera_url : where the camera's pictures are.
    """

    def __init__(self, bench: EmulatedRig) -> None:
        self.bench = bench
        self.force = RdtServer(bench.box, bench.clock)
        self._serial = VirtualSerialPort(bench.answer)
        self._camera = CameraServer(bench.camera, bench.clock)
        self._idle = VirtualSerialPort(bench.idle)
        self.port, self.idle_port, self.camera_url = self._serial.name, self._idle.name, self._camera.url
        self._open = ExitStack()

    def start(self) -> None:
        """Begin to serve."""
        for server in (self._serial, self._idle, self.force, self._camera):
            self._open.enter_context(server)

    def close(self) -> None:
        """End, and give ports back."""
        self._open.close()

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()
