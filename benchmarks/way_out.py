"""The way out of broken states, over real bytes and in real time: is the probe taken away, and is it told?

``python -m benchmarks.way_out | python -m benchmarks.bench.record way_out``: about 4 minutes. A program presses S1 with
`emg2vsa rig run` on an emulated rig behind ports; something breaks at 5 N. Force is the world's own.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.rig.plans import modular_plan
from emg2vsa.lab.emulation import emulation
from emg2vsa.rig_file import load_rig
from emg2vsa.schedule_files import write_schedule
from emg2vsa.worlds.bench.bench import EmulatedRig
from emg2vsa.worlds.bench.faults import put

BREAKS_N, FREE_N = 5.0, 0.1
CONDITIONS = {"qbmove": "modular", "rigid": "high-stiffness"}
RIG = """
[actuator]
kind = "qbmove"
model = "advanced"
[motor]
[force]
kind = "net-ft"
[camera]
source = "omitted"
[experiment]
schedules = "."
specimens = ["S1"]
repetitions = 3
f_max_n = 7
lead_s = 0.04
pause_s = 0.5
stiffness_n_per_mm = { S1 = 7.63 }
angles_deg = { modular = [0], high-stiffness = [0] }
[emulated]
world = "elastic"
springs = "qbmove-advanced"
stiffness_n_per_mm = { S1 = 7.63 }
"""


@dataclass(frozen=True)
class Broken:
    """What is at hand when a state breaks."""

    bench: EmulatedRig
    process: subprocess.Popen[bytes]
    unplug: Callable[[], None]
    folder: Path

    def say(self, *lines: str) -> None:
        """Faults of the emulated rig."""
        for line in lines:
            put(self.bench, line)

    def send(self, *numbers: signal.Signals, between_s: float = 0.05) -> None:
        """Signals to the program, one after the other."""
        for number in numbers:
            self.process.send_signal(number)
            time.sleep(between_s)


def _stopped(broken: Broken) -> None:
    broken.send(signal.SIGSTOP, between_s=5.0)
    broken.send(signal.SIGCONT)


def _full(broken: Broken) -> None:
    largest = max(path.stat().st_size for path in broken.folder.rglob("frames.tif"))
    resource.prlimit(broken.process.pid, resource.RLIMIT_FSIZE, (largest, largest))


STATES: dict[str, Callable[[Broken], None]] = {
    "line dead for 1 s": lambda at: at.say("deaf for 1 s"),
    "line dead for 3 s": lambda at: at.say("deaf for 3 s"),
    "device reset": lambda at: at.say("reset"),
    "24 V lost for 1 s": lambda at: at.say("brown-out for 1 s"),
    "commands ignored for 1.5 s": lambda at: at.say("ignore for 1.5 s"),
    "SIGTERM twice": lambda at: at.send(signal.SIGTERM, signal.SIGTERM),
    "Ctrl-C three times": lambda at: at.send(signal.SIGINT, signal.SIGINT, signal.SIGINT),
    "program stopped for 5 s": _stopped,
    "force sensor mute": lambda at: at.say("silent"),
    "disk full": _full,
    "everything unplugged": lambda at: at.unplug(),
}


@dataclass(frozen=True)
class Left:
    """How a program ended. status : of it. most_n, left_n : true force. told : ended.json; empty without one.

    ended_s : from the break until the program was over. on : whether the motors are on then."""

    status: int
    told: dict[str, object]
    most_n: float
    left_n: float
    ended_s: float
    on: bool


def break_it(state: str, actuator: str, folder: Path) -> Left:
    """Press, break, and look."""
    (folder / "rig.toml").write_text(RIG)
    schedule = modular_plan(1, specimen="S1").schedule
    assert schedule is not None
    write_schedule(folder, schedule)
    command = [sys.executable, "-m", "emg2vsa.cli", "rig", "run", str(folder / "served.toml"), "--specimen", "S1"]
    command += ["--angle", "0", "--condition", CONDITIONS[actuator], "--out", str(folder / "runs")]
    most_n = 0.0
    with ExitStack() as plugged:
        file, write = load_rig(folder / "rig.toml"), folder / "served.toml"
        served = plugged.enter_context(emulation(file, specimen="S1", rigid=actuator == "rigid", write=write))
        bench = served.servers.bench
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            end_s = time.monotonic() + 60
            while bench.probe()[1] < BREAKS_N and process.poll() is None and time.monotonic() < end_s:
                time.sleep(0.002)
            broken_s = time.monotonic()
            breaking = threading.Thread(target=STATES[state], args=[Broken(bench, process, plugged.close, folder)])
            breaking.start()
            while process.poll() is None and time.monotonic() < end_s:
                most_n = max(most_n, bench.probe()[1])
                time.sleep(0.002)
            ended_s = time.monotonic() - broken_s
            breaking.join()
            process.kill()
        time.sleep(1.0)  # a watchdog runs out, and the shaft comes to rest
        left_n, on = bench.probe()[1], bool(bench.firmware.ask_active())
    (told,) = [json.loads(path.read_text()) for path in folder.glob("runs/*/ended.json")] or [{}]
    return Left(process.returncode, told, most_n, left_n, ended_s, on)


def rows() -> Iterator[str]:
    yield "# The way out of broken states\n"
    yield f"`emg2vsa rig run` presses S1 to 7 N over real bytes; the state breaks at {BREAKS_N:g} N. Left is the force"
    yield "on the specimen 1 s after the program has ended; the status is 1 where a run was not completed.\n"
    yield (
        "| state | actuator | ended | cause | retracted, told | motors off | largest (N) | left (N) | over after (s) "
        "| status |"
    )
    yield "|---|---|---|---|---|---|---:|---:|---:|---:|"
    for state in STATES:
        for actuator in CONDITIONS:
            with TemporaryDirectory() as folder:
                left = break_it(state, actuator, Path(folder))
            told = left.told
            words = f"{told.get('how')} | {told.get('cause')} | {'yes' if told.get('retracted') else 'no'}"
            off = "no" if left.on else "yes"
            forces = f"{left.most_n:.1f} | {left.left_n:.1f} | {left.ended_s:.1f}"
            yield f"| {state} | {actuator} | {words} | {off} | {forces} | {left.status} |"


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    for line in rows():
        print(line, flush=True)
