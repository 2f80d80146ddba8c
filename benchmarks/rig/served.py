"""The emulated rig in a process of its own: ``python -m benchmarks.rig.served`` until its input ends.

The first line of output is JSON with where to find it, the last one the share of a processor that it took.
"""

from __future__ import annotations

import json
import sys
import time

from benchmarks.rig.plans import SPECIMEN
from emg2vsa.devices.clock import WallClock
from emg2vsa.worlds.bench.bench import EmulatedRig, EmulatedServers
from emg2vsa.worlds.bench.settings import EmulatedSettings


def main() -> None:
    """Serve until standard input is closed."""
    # a thread that is to answer at once would else wait 5 ms for the one that draws a frame
    sys.setswitchinterval(2e-4)
    bench = EmulatedRig(EmulatedSettings(), SPECIMEN, 0.0, rigid=False, clock=WallClock())
    with EmulatedServers(bench) as servers:
        force = servers.force
        print(
            json.dumps(
                {
                    "port": servers.port, "host": force.host, "rdt_port": force.rdt_port, "http_port": force.http_port,
                    "camera": servers.camera_url,
                }
            ),
            flush=True,
        )  # fmt: skip
        started_s, before_s = time.perf_counter(), time.process_time()
        sys.stdin.read()
        used = (time.process_time() - before_s) / (time.perf_counter() - started_s)
        print(json.dumps({"cpu_share": used}), flush=True)


if __name__ == "__main__":
    main()
