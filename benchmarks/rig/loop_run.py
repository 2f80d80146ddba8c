"""One run of the executor against the emulated rig in another process, and what is to be known of its timing.

``python -m benchmarks.rig.loop_run RATE`` keeps the beat of a loop with nothing to do until its input ends, and prints
its timing as JSON: what it misses, on the same machine at the same time, no loop can keep.

Processes beside the loop: the emulated rig, a loop with nothing to do, and programs that only take processors.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path
from typing import IO, Any

import numpy as np

from benchmarks.rig.fault_case import read_log
from benchmarks.rig.plans import modular_plan
from emg2vsa.devices.clock import LEAST_PRIORITY, Beat, Clock, LoopTiming, WallClock, ahead, undisturbed
from emg2vsa.devices.netft import NetFtSettings
from emg2vsa.devices.opencv_camera import OpenCvSettings
from emg2vsa.devices.protocols import Actuator, Devices, Joint, LogColumns, Measurements
from emg2vsa.devices.qbmove import QbmoveSettings
from emg2vsa.rig.executor.execute import execute
from emg2vsa.rig.open_rig import open_rig
from emg2vsa.rig.record.run_log import Row
from emg2vsa.rig.rig_settings import DeviceSettings, GuardSettings, RigSettings

HOG = "while True: pass"


@dataclass
class Served:
    """The emulated rig in another process: how to reach it, and, once it has ended, its share of a processor."""

    settings: DeviceSettings
    cpu_share: float = 0.0


@dataclass
class BareLoop:
    """How well a loop with nothing to do has kept its beat; known once it has ended."""

    timing: LoopTiming | None = None


@contextmanager
def served_rig(real_time: bool) -> Iterator[Served]:
    """Start it and end it. ``real_time``: no program keeps it waiting, as none does a real device."""
    with _module("benchmarks.rig.plans") as process:
        at = json.loads(_lines(process).readline())
        if real_time:
            _make_real_time(process.pid)
        served = Served(
            DeviceSettings(
                actuator=QbmoveSettings(port=at["port"]),
                force=NetFtSettings(host=at["host"], rdt_port=at["rdt_port"], http_port=at["http_port"]),
                camera=OpenCvSettings(source=at["camera"]),
            )
        )
        yield served
        served.cpu_share = json.loads(process.communicate()[0])["cpu_share"]


@contextmanager
def bare_loop(rate_hz: float) -> Iterator[BareLoop]:
    """Start and end it; scheduled as the program that starts it."""
    with _module("benchmarks.rig.loop_run", str(rate_hz)) as process:
        bare = BareLoop()
        yield bare
        bare.timing = LoopTiming(**json.loads(process.communicate()[0]))


@contextmanager
def hogs(count: int) -> Iterator[None]:
    """So many programs that take all the time they get, at ordinary priority."""
    running = [subprocess.Popen([sys.executable, "-c", HOG]) for _ in range(count)]
    try:
        yield
    finally:
        for process in running:
            process.kill()
            process.wait()


@contextmanager
def _module(name: str, *arguments: str) -> Iterator[subprocess.Popen[str]]:
    """A module run as a program until its input ends."""
    command = [sys.executable, "-m", name, *arguments]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def _lines(process: subprocess.Popen[str]) -> IO[str]:
    assert process.stdout is not None
    return process.stdout


def _make_real_time(process_id: int) -> None:
    for thread in os.listdir(f"/proc/{process_id}/task"):
        with suppress(OSError):
            os.sched_setscheduler(int(thread), os.SCHED_FIFO, os.sched_param(LEAST_PRIORITY))


SETTLED = 0.9
"Part of a step at which the motors count as there."
MOVING = 0.1


@dataclass
class TimedActuator:
    """An actuator with the time of every command and of every measurement's arrival, s."""

    actuator: Actuator
    clock: Clock
    commands: list[tuple[float, float]] = field(default_factory=list)
    "Time when sent, preset."
    presets: list[tuple[float, float]] = field(default_factory=list)
    "Time when measured, preset that the motors have, degrees."

    def activate(self) -> None:
        self.actuator.activate()

    def deactivate(self) -> None:
        self.actuator.deactivate()

    def is_active(self) -> bool:
        return self.actuator.is_active()

    def command(self, position_deg: float, preset: float) -> None:
        self.actuator.command(position_deg, preset)
        self.commands.append((self.clock.now_s(), preset))

    def position_deg(self) -> float:
        return self.actuator.position_deg()

    def measurements(self) -> Measurements:
        at = self.actuator.measurements()
        self.presets.append((self.clock.now_s(), (at.motors_deg[0] - at.motors_deg[1]) / 2))
        return at

    def currents_a(self) -> tuple[float, ...]:
        return self.actuator.currents_a()

    def current_limit_a(self) -> float:
        return self.actuator.current_limit_a()

    @property
    def joint(self) -> Joint | None:
        """Of the actuator."""
        return self.actuator.joint

    @property
    def columns(self) -> LogColumns:
        """Of the actuator."""
        return self.actuator.columns


@dataclass(frozen=True)
class StepLatency:
    """Of every step up during loading, s; not a number where the press was over before."""

    command_s: list[float]
    moving_s: list[float]
    settled_s: list[float]


def step_latency(rows: list[Row], timed: TimedActuator) -> StepLatency:
    """From the start of the turn that read the force to the command sent, and to motors seen at a part of the step.

    Steps follow each other faster than motors do, so a step may be seen after the command of the next.
    """
    found = StepLatency([], [], [])
    sent_s = np.array([time_s for time_s, _ in timed.commands])
    seen_s, presets = np.array(timed.presets).T
    over_s = {row.repetition: row.time_s for row in rows if row.phase == "retract"}
    for before, row in pairwise(rows):
        low, high = before.preset, row.preset
        if row.phase != "load" or low is None or high is None or high <= low:
            continue
        start_s = row.time_s
        found.command_s.append(float(sent_s[np.searchsorted(sent_s, start_s)]) - start_s)
        seen = slice(np.searchsorted(seen_s, start_s), np.searchsorted(seen_s, over_s.get(row.repetition, start_s)))
        for latencies, part in ((found.moving_s, MOVING), (found.settled_s, SETTLED)):
            there = np.flatnonzero(presets[seen] >= low + part * (high - low))
            latencies.append(float(seen_s[seen][there[0]]) - start_s if there.size else np.nan)
    return found


def main() -> None:
    """Beat until standard input is closed."""
    ended = threading.Event()
    threading.Thread(target=lambda: (sys.stdin.read(), ended.set()), daemon=True).start()
    beat = Beat(WallClock(), 1 / float(sys.argv[1]))
    with ahead():
        while not ended.is_set():
            beat.wait()
    print(json.dumps(asdict(beat.timing())))


PATIENT = GuardSettings(stale_s=1.0, camera_s=2.0, late_s=1.0)
"""What is measured must not end the measurement; the run of a rig is ended by a turn that is 50 ms late."""
ENOUGH = 100_000
"""Repetitions: the time ends a run, not the plan."""


@dataclass(frozen=True)
class LoopReport:
    """One run."""

    hogs: int
    real_time: bool
    how: str
    why: str
    loop: LoopTiming
    bare: LoopTiming
    "The beat with nothing to do, at the same time."
    rows: int
    rows_lost: int
    "Turns without their row."
    frames_kept: int
    frames_dropped: int
    force_lost: int
    "Records that never came."
    replies_lost: int
    steps: StepLatency
    cpu_share: float
    "Of one processor, as is the emulator's."
    emulator_cpu_share: float
    memory_mb: tuple[float, float]
    "At most before the run, and after."
    load_average: float


def run_loop(duration_s: float, n_hogs: int, *, steady: bool) -> LoopReport:
    """Press for ``duration_s`` beside ``n_hogs`` programs. steady : with `undisturbed`."""
    rig = RigSettings(guards=PATIENT)
    with tempfile.TemporaryDirectory() as name, hogs(n_hogs), served_rig(steady) as served:
        folder = Path(name) / "run"
        with undisturbed() if steady else nullcontext(False) as real_time, bare_loop(rig.rate_hz) as bare:
            actuator = replace(served.settings.actuator, reply_s=PATIENT.late_s)
            found = _pressed(replace(served.settings, actuator=actuator), rig, folder, duration_s)
        rows = read_log(folder / "log.csv")
    timing, timed = found.pop("loop"), found.pop("timed")
    assert bare.timing is not None
    return LoopReport(
        hogs=n_hogs, real_time=real_time, loop=timing, bare=bare.timing, rows=len(rows),
        rows_lost=timing.turns - sum(row.phase != "escape" for row in rows),
        frames_kept=_frames(rows), steps=step_latency(rows, timed),
        emulator_cpu_share=served.cpu_share, load_average=os.getloadavg()[0], **found,
    )  # fmt: skip


def _pressed(settings: DeviceSettings, rig: RigSettings, folder: Path, duration_s: float) -> dict[str, Any]:
    clock = WallClock()
    with open_rig(settings, rig, "modular", clock) as opened:
        devices: Any = opened.devices
        timed = TimedActuator(devices.actuator, clock)
        end_s, before_s, before_mb = clock.now_s() + duration_s, time.process_time(), _memory_mb()
        ended = execute(
            modular_plan(ENOUGH), opened.rig, Devices(timed, devices.force, devices.camera), folder, clock,
            started=datetime.now(UTC), stop=lambda: "time" if clock.now_s() >= end_s else None, background=True,
        )  # fmt: skip
        return {
            "how": ended.how, "why": ended.why, "loop": ended.timing, "timed": timed,
            "frames_dropped": devices.camera.dropped, "force_lost": devices.force.counts().lost,
            "replies_lost": devices.actuator.counts.lost, "memory_mb": (before_mb, _memory_mb()),
            "cpu_share": (time.process_time() - before_s) / duration_s,
        }  # fmt: skip


def _frames(rows: list[Row]) -> int:
    last = {row.repetition: 0 for row in rows}
    for row in rows:
        last[row.repetition] = max(last[row.repetition], row.frame_index + 1)
    return sum(last.values())


def _memory_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


if __name__ == "__main__":
    main()
