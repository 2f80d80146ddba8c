"""The beat of the control loop with nothing to do: ``python -m benchmarks.rig.bare_loop RATE`` until its input ends.

What this loop misses, on the same machine at the same time, no loop can keep. The timing is printed as JSON.
"""

from __future__ import annotations

import json
import sys
import threading
from dataclasses import asdict

from emg2vsa.devices.clock import Beat, WallClock, ahead


def main() -> None:
    """Beat until standard input is closed."""
    ended = threading.Event()
    threading.Thread(target=lambda: (sys.stdin.read(), ended.set()), daemon=True).start()
    beat = Beat(WallClock(), 1 / float(sys.argv[1]))
    with ahead():
        while not ended.is_set():
            beat.wait()
    print(json.dumps(asdict(beat.timing())))


if __name__ == "__main__":
    main()
