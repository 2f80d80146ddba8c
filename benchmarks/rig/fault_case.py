"""One fault in one phase of a run: what happened, by the world's own truth, and what the files say of it.

What a run that went wrong has not on disk of all that came before.

All rows of a log, for benchmarks and tests.
"""

from __future__ import annotations

import json
import math
import sys
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from benchmarks.rig.fault_bench import GAP_MM, Built, FaultBench, Strike
from benchmarks.rig.faults import BEFORE, FAULTS, WRONG_RIGS, End, Fault
from benchmarks.rig.plans import dynamixel_plan, modular_plan, rigid_plan
from casr.frame_files import open_frames, read_force_log
from emg2vsa.errors import ScheduleError, SettingError
from emg2vsa.live.tails import LogTail
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.record.run_log import Row
from emg2vsa.rig.rig_settings import RigSettings

LOADING = ("approach", "contact", "load")


class Lost(NamedTuple):
    """Counts; 0 when all is there."""

    rows: int
    "Turns before the fault without a row in log.csv, and the last row when it is not whole."
    forces: int
    "Readings of the loading before the fault that force.csv lacks."
    frames: int
    "Frames that the log knows and the press has not."


def lost_data(folder: Path, until_s: float) -> Lost:
    """Of the run in ``folder`` up to ``until_s`` of its clock. RecordingError, FramesError: what is there is spoilt."""
    log = folder / "log.csv"
    rows = [row for row in read_log(log) if row.time_s < until_s]
    loading = [row for row in rows if row.phase in LOADING and row.force_n is not None]
    n_frames = 1 + max((row.frame_index for row in loading), default=-1)
    forces = frames = 0
    # fewer than two frames are no press
    if n_frames > 1:
        press = next(folder.glob("press-*"))
        times = read_force_log(press / "force.csv").time_s
        forces = len({row.force_time_s for row in loading} - set([] if times is None else times.tolist()))
        frames = max(0, n_frames - len(open_frames(press / "frames.tif")))
    return Lost(_turns(rows, until_s) + (not log.read_bytes().endswith(b"\n")), forces, frames)


def _turns(rows: list[Row], until_s: float) -> int:
    """Missing between rows, and between the last of them and the fault."""
    if not rows:
        return 0
    period_s = RigSettings().period_s
    times_s = [*(row.time_s for row in rows), until_s]
    return sum(max(0, round((after - before) / period_s) - 1) for before, after in pairwise(times_s))


def read_log(path: Path) -> list[Row]:
    """All whole rows. RecordingError for anything else."""
    return LogTail(path, sys.maxsize).new_rows()


PHASES = ("activation", "home", "approach", "contact", "load", "retract", "pause", "escape")
TOP = "top"
"""Of the load: near the largest force."""
_MIDST_OF_ACTIVATION = 30
"""Words of a Dynamixel's."""
WHOLE_RUN = "whole run"
"""The phase of a wrong rig file."""
F_MAX_N, PAUSE_S = 7.0, 1.0
WATCHDOG_S = 1.0
"""Longer than any watchdog of a run."""
RIG = RigSettings()
MOST_N = 1.3 * RIG.guards.force_n
"""What a specimen may feel, whatever goes wrong."""
FREE_N = 0.05
OFF_SURFACE_MM = 0.25 * GAP_MM


@dataclass(frozen=True)
class Outcome:
    """One case.

    wanted : how the run may end. told : ended.json. movable : the probe could be taken
    away in the end. late_home : but perhaps not all the way.
    most_n : what the specimen may feel.
    safe_s : from the fault until the motors were off, as the device itself knows, or stopped by their watchdog; None is
    never. off : they are off at the end.
    probe_mm : where the motors have left the probe, by the device's encoders.
    peak_n, left_n : largest true force on the specimen after the fault, and the one that is left at the end.
    most_felt_n : what the run says of its largest force, None where it says nothing. true_n : what that was.
    retracted : in truth, the probe is off the specimen.
    retreat_s, guard_s : from the fault, and from the end of the loop, until the first command of the way out; None
    without one. lost : before the fault. next_run : its ended.json.
    """

    wanted: tuple[End, ...]
    told: dict[str, Any]
    movable: bool
    late_home: bool
    most_n: float
    safe_s: float | None
    off: bool
    probe_mm: float
    peak_n: float
    left_n: float
    true_n: float
    most_felt_n: float | None
    retracted: bool
    retreat_s: float | None
    guard_s: float | None
    lost: Lost
    next_run: dict[str, Any]

    def failures(self) -> list[str]:
        """What must not be, in words; empty when the case is passed."""
        told = self.told
        next_whole = self.next_run["how"] == "completed" and self.next_run["retracted"]
        rules = {
            f"more than {self.most_n:.3g} N": self.peak_n > self.most_n,
            "completed, not retracted": told["how"] == "completed" and not (self.retracted and told["retracted"]),
            "retracted is not true": told["retracted"] and not self.retracted,
            "motors off is not true": told["deactivated"] and not self.off,
            "motors stay on": self.safe_s is None,
            "probe is left": self.movable and not (self.retracted and (told["retracted"] or self.late_home)),
            "cause": (told["how"], told["cause"]) not in self.wanted,
            "data lost": any(self.lost),
            "next run": not next_whole,
        }
        return [words for words, broken in rules.items() if broken]


def run_case(name: str, phase: str, folder: Path, *, rigid: bool = False) -> Outcome:
    """Carry it out in ``folder``: a run with the fault, then one without, on the same devices."""
    fault = FAULTS[name]
    return run_fault(fault, phase, Built(rigid=rigid), folder, fault.ends_in(phase), MOST_N, BEFORE.get(name))


def run_fault(
    fault: Fault,
    phase: str,
    built: Built,
    folder: Path,
    wanted: tuple[End, ...],
    most_n: float,
    before: Strike | None = None,
) -> Outcome:
    """As `run_case` with any fault on any bench. ``wanted`` : how it may end. ``before`` : what is wrong from the
    beginning."""
    bench = FaultBench(built)
    watch = _Watch(bench, phase_times(built)[phase])
    bench.clock.strike = lambda: fault.strike(bench)
    if built.actuator and phase == "activation":  # its words take no time
        bench.clock.strike_s, bench.line.later = math.inf, (_MIDST_OF_ACTIVATION, bench.clock.strike)
    if phase == "escape":
        bench.stop_s = phase_times(built)["load"]
    if before:
        before(bench)
    return _outcome(bench, watch, wanted, fault.probe, most_n, folder)


def run_wrong(name: str, folder: Path) -> Outcome:
    """As `run_case` with a rig file that is wrong from the beginning."""
    return run_rig(*WRONG_RIGS[name], folder, MOST_N)


def run_rig(built: Built, wanted: tuple[End, ...], folder: Path, most_n: float) -> Outcome:
    """As `run_wrong` with any wrong rig."""
    bench = FaultBench(built)
    return _outcome(bench, _Watch(bench, bench.clock.now_s()), wanted, False, most_n, folder)


def _outcome(
    bench: FaultBench, watch: _Watch, wanted: tuple[End, ...], probe: str, most_n: float, folder: Path
) -> Outcome:
    run = folder / "run"
    try:
        with suppress(ZeroDivisionError):
            bench.run(plan_of(bench.built), run)
        told = json.loads((run / "ended.json").read_text())
    except (SettingError, ScheduleError) as error:
        told = {"how": "refused", "cause": type(error).__name__, "time_s": math.nan, "phase": ""}
        told |= {"retracted": False, "deactivated": False}
    watch.until_safe()
    left_n, retracted = bench.true_force_n(), bench.true_probe_mm() < GAP_MM - OFF_SURFACE_MM
    off = not bench.motors_on()
    left_at = [row.time_s for row in _rows(run) if row.phase == "escape" and row.time_s >= watch.from_s]
    retreat_s = min([*left_at[:1], bench.line.off_s])
    bench.heal()
    probe_mm = bench.probe_mm()
    bench.tell_the_truth()
    bench.run(_next_plan(bench.built), folder / "next")
    known = math.isfinite(retreat_s) and told["how"] not in ("completed", "refused")
    return Outcome(
        wanted=wanted,
        told=told,
        late_home=probe == "free",
        movable=probe in ("retracted", "free") and told["phase"] not in ("", "activation") and told["how"] != "killed",
        most_n=most_n,
        safe_s=watch.safe_s,
        off=off,
        probe_mm=probe_mm,
        peak_n=watch.peak_n,
        left_n=left_n,
        true_n=watch.whole_n,
        most_felt_n=told.get("peak_force_n"),
        retracted=retracted and left_n < FREE_N,
        retreat_s=retreat_s - watch.from_s if known else None,
        guard_s=retreat_s - told["time_s"] if known and told["time_s"] >= watch.from_s else None,
        lost=lost_data(run, watch.from_s) if _rows(run) else Lost(0, 0, 0),
        next_run=json.loads((folder / "next" / "ended.json").read_text()),
    )


def _rows(run: Path) -> list[Any]:
    return read_log(run / "log.csv") if (run / "log.csv").exists() else []


@cache
def phase_times(built: Built) -> dict[str, float]:
    """A time in the midst of each phase, and near the largest force, on the clock of every `FaultBench` so built."""
    with TemporaryDirectory() as folder:
        bench = FaultBench(built)
        bench.run(plan_of(built), Path(folder) / "whole")
        whole = read_log(Path(folder) / "whole" / "log.csv")
        times = {phase: [row.time_s for row in whole if row.phase == phase] for phase in PHASES[1:-1]}
        stopped = FaultBench(built)
        stopped.stop_s = _middle(times["load"])
        stopped.run(plan_of(built), Path(folder) / "stopped")
        rows = read_log(Path(folder) / "stopped" / "log.csv")
        times["escape"] = [row.time_s for row in rows if row.phase == "escape"]
    # the camera is lost after half a second, which must fit into the pause
    return (
        {"activation": bench.begun_s + RIG.period_s}
        | {phase: _middle(found, 0.25) for phase, found in times.items()}
        | {TOP: _middle(times["load"], 0.97)}
    )


class _Watch:
    """What the devices do from a moment on, looked at in every sleep of the clock."""

    def __init__(self, bench: FaultBench, from_s: float) -> None:
        self._bench, self.from_s = bench, from_s
        self.safe_s: float | None = None
        self.peak_n = self.whole_n = 0.0
        bench.clock.strike_s, bench.clock.watch = from_s, self._look

    def _look(self) -> None:
        now_s, force_n = self._bench.clock.now_s(), self._bench.true_force_n()
        self.whole_n = max(self.whole_n, force_n)
        if now_s < self.from_s:
            return
        on = self._bench.motors_on() and not self._bench.held()
        self.peak_n = max(self.peak_n, force_n)
        if not on:
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


def plan_of(built: Built, f_max_n: float = F_MAX_N, pause_s: float = PAUSE_S) -> RunPlan:
    """One press on a bench that is so built."""
    changes: dict[str, Any] = {"f_max_n": f_max_n, "pause_s": pause_s}
    if built.actuator:
        return dynamixel_plan(built.actuator, built.true.gear_mm_per_degree, 1, built.specimen, **changes)
    return (rigid_plan if built.rigid else modular_plan)(1, specimen=built.specimen, **changes)


def _next_plan(built: Built) -> RunPlan:
    return plan_of(built, 2.0, 0.0)


def _middle(times_s: list[float], part: float = 0.5) -> float:
    # between two turns
    return times_s[int(part * len(times_s))] - RIG.period_s / 2
