"""The emulated rig in a process of its own: ``python -m benchmarks.rig.served`` until its input ends.

Its first line of output is JSON with where to find it: serial port, ports of the force sensor's box, camera's URL.
"""

from __future__ import annotations

import json
import sys
import time

from benchmarks.rig.parts import emulated_parts
from emg2vsa.rig.clock import WallClock
from emg2vsa.rig.emulated.camera_server import CameraServer
from emg2vsa.rig.emulated.rdt_server import RdtServer
from emg2vsa.rig.emulated.serial_port import VirtualSerialPort


def main() -> None:
    """Serve until standard input is closed; the CPU time that took is the last line."""
    # threads that answer within a millisecond must not wait 5 ms for one that draws a frame
    sys.setswitchinterval(2e-4)
    clock = WallClock()
    parts = emulated_parts(clock)

    def actuator(data: bytes) -> bytes:
        with parts.lock:
            return parts.wire(data)

    with (
        VirtualSerialPort(actuator) as port,
        RdtServer(parts.box, clock) as box,
        CameraServer(parts.camera, clock) as camera,
    ):
        where = {"port": port.name, "host": box.host, "rdt_port": box.rdt_port, "http_port": box.http_port}
        print(json.dumps(where | {"camera": camera.url}), flush=True)
        started_s, before_s = clock.now_s(), time.process_time()
        sys.stdin.read()
        used = (time.process_time() - before_s) / (clock.now_s() - started_s)
        print(json.dumps({"cpu_share": used}), flush=True)


if __name__ == "__main__":
    main()
