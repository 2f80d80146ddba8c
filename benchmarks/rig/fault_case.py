"""One fault in one phase of a run: what happened, on the devices' own word and on that of the files."""

from __future__ import annotations

import json
import math
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.rig.fault_bench import FaultBench
from benchmarks.rig.faults import FAULTS, End
from benchmarks.rig.logs import read_log
from benchmarks.rig.lost_data import Lost, lost_data
from benchmarks.rig.plans import modular_plan
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.record.ended import Ended
from emg2vsa.rig.rig_settings import RigSettings

PHASES = ("activation", "home", "approach", "contact", "load", "retract", "pause", "escape")
F_MAX_N, PAUSE_S = 5.0, 1.0
WATCHDOG_S = 1.0
"""Longer than any watchdog of a run."""
RIG = RigSettings()


@dataclass(frozen=True)
class Outcome:
    """One case."""

    wanted: End
    told: dict[str, Any]
    "ended.json."
    safe_s: float | None
    "From the fault until the motors were off, as the device itself knows."
    probe_mm: float
    "Where the motors have left the probe, by the device's encoders."
    peak_n: float
    "Largest true force on the specimen after the fault."
    lost: Lost
    next_run: Ended


def run_case(name: str, phase: str, folder: Path) -> Outcome:
    """Carry it out in ``folder``: a run with the fault, then one without, on the same devices."""
    fault, bench = FAULTS[name], FaultBench()
    watch = _Watch(bench, phase_times()[phase])
    bench.clock.strike = lambda: fault.strike(bench)
    if phase == "escape":
        bench.stop_s = phase_times()["load"]
    with suppress(ZeroDivisionError):
        bench.run(_plan(), folder / "run")
    watch.until_safe()
    bench.heal()
    probe_mm = bench.probe_mm()
    return Outcome(
        wanted=fault.ends(phase), told=json.loads((folder / "run" / "ended.json").read_text()),
        safe_s=watch.safe_s, probe_mm=probe_mm, peak_n=watch.peak_n, lost=lost_data(folder / "run", watch.from_s),
        next_run=bench.run(modular_plan(1, f_max_n=2.0, pause_s=0.0), folder / "next"),
    )  # fmt: skip


@cache
def phase_times() -> dict[str, float]:
    """A time in the midst of each phase, on the clock of every `FaultBench`."""
    with TemporaryDirectory() as folder:
        bench = FaultBench()
        bench.run(_plan(), Path(folder) / "whole")
        whole = read_log(Path(folder) / "whole" / "log.csv")
        times = {phase: [row.time_s for row in whole if row.phase == phase] for phase in PHASES[1:-1]}
        stopped = FaultBench()
        stopped.stop_s = _middle(times["load"])
        stopped.run(_plan(), Path(folder) / "stopped")
        rows = read_log(Path(folder) / "stopped" / "log.csv")
        times["escape"] = [row.time_s for row in rows if row.phase == "escape"]
    # the camera is lost after half a second, which must fit into the pause
    return {"activation": bench.begun_s + RIG.period_s} | {
        phase: _middle(found, 0.25) for phase, found in times.items()
    }


class _Watch:
    """What the devices do from a moment on, looked at in every sleep of the clock."""

    def __init__(self, bench: FaultBench, from_s: float) -> None:
        self._bench, self.from_s = bench, from_s
        self.safe_s: float | None = None
        self.peak_n = 0.0
        bench.clock.strike_s, bench.clock.watch = from_s, self._look

    def _look(self) -> None:
        now_s, emulated = self._bench.clock.now_s(), self._bench.emulated
        if now_s < self.from_s:
            return
        self.peak_n = max(self.peak_n, emulated.world.normal_force_n(now_s))
        if not emulated.firmware.state.on:
            self.safe_s = now_s - self.from_s if self.safe_s is None else self.safe_s
        else:
            self.safe_s = None

    def until_safe(self) -> None:
        """A device that hears nothing goes off by its watchdog; nobody looks at what comes after."""
        clock = self._bench.clock
        end_s = clock.now_s() + WATCHDOG_S
        while self.safe_s is None and clock.now_s() < end_s:
            clock.sleep_until(clock.now_s() + 0.01)
        clock.strike_s, clock.watch = math.inf, lambda: None


def _plan() -> RunPlan:
    return modular_plan(1, f_max_n=F_MAX_N, pause_s=PAUSE_S)


def _middle(times_s: list[float], part: float = 0.5) -> float:
    # between two turns
    return times_s[int(part * len(times_s))] - RIG.period_s / 2
