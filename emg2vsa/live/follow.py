"""What the page shows at one moment of the run in a folder, or of the newest of the runs below it, as it grows."""

from __future__ import annotations

import math
import os
import time
from bisect import bisect_left
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from emg2vsa.devices.clock import LATE_PERIODS
from emg2vsa.errors import RecordingError
from emg2vsa.live.run_facts import Ending, RunFacts, read_ending, read_run
from emg2vsa.live.tails import Column, KappaTail, KappaView, LogTail
from emg2vsa.rig.executor.stop_requests import stop_requested
from emg2vsa.rig.record.new_folder import PLAN_FILE
from emg2vsa.rig.record.press_counts import forces_of, largest_forces, weighed
from emg2vsa.rig.record.run_log import Row
from emg2vsa.rig.rig_settings import RigSettings

WINDOW_S = 15.0
"""Length of the curves."""


@dataclass(frozen=True)
class Curves:
    """New samples, (n,) each, oldest first; None where a turn of the loop had none."""

    time_s: Column = field(default_factory=list)
    raw_n: Column = field(default_factory=list)
    filtered_n: Column = field(default_factory=list)
    preset: Column = field(default_factory=list)
    "Commanded, in the unit of the run's full preset."
    measured_preset: Column = field(default_factory=list)
    "Half the difference of the two motors, equation (8); None of one motor."
    depth_mm: Column = field(default_factory=list)
    "Commanded."
    shaft_mm: Column = field(default_factory=list)
    "Measured at the output shaft, behind the springs."


@dataclass(frozen=True)
class Snapshot:
    """One moment."""

    folder: str
    "Folder that is followed."
    run: RunFacts | None = None
    "None while there is no run."
    curves: Curves = field(default_factory=Curves)
    phase: str = ""
    repetition: int = 0
    "Number of the press, from 1; 0 before the first press."
    presses_done: int = 0
    largest_n: float = 0.0
    "Largest force of the run along push_axis, of either sign, N."
    largest_across_n: float = 0.0
    "Largest force of the run across it."
    turns: int = 0
    "Turns of the control loop since somebody watches."
    late_turns: int = 0
    "Turns that were late."
    latest_ms: float = 0.0
    "Largest delay of one of these."
    frame: str = ""
    "Changes with every frame; empty when there is none."
    age_s: float | None = None
    "Since the log last grew; None without a log."
    weighed: str = ""
    "Stiffness of the specimen by force over depth of the last press that tells it."
    kappa: KappaView | None = None
    "None where presses are not judged while they go on."
    stop_requested: bool = False
    ended: Ending | None = None
    trouble: str = ""
    "Why the folder cannot be shown."
    anew: bool = False
    "The curves are all there are, and not what came since the last moment."


def curves_of(rows: Sequence[Row], rig: RigSettings) -> Curves:
    """Curves of the rows within ``WINDOW_S`` of the last."""
    recent = [row for row in rows if row.time_s >= rows[-1].time_s - WINDOW_S]
    return Curves(
        [round(row.time_s, 4) for row in recent],
        [_rounded(row.force_n) for row in recent],
        [_rounded(row.filtered_n) for row in recent],
        [_rounded(row.preset) for row in recent],
        [_half_difference(row) for row in recent],
        [_depth(row.position_deg, rig) for row in recent],
        [_depth(row.at and row.at.shaft_deg, rig) for row in recent],
    )


def joined(before: Curves, after: Curves) -> Curves:
    """Both, as far as they are within ``WINDOW_S`` of the last sample."""
    columns = {name: [*values, *getattr(after, name)] for name, values in vars(before).items()}
    times_s = columns["time_s"]
    first = bisect_left(times_s, times_s[-1] - WINDOW_S) if times_s else 0
    return Curves(**{name: values[first:] for name, values in columns.items()})


def _half_difference(row: Row) -> float | None:
    if row.at is None or len(row.at.motors_deg) < 2:
        return None
    return _rounded((row.at.motors_deg[0] - row.at.motors_deg[1]) / 2)


def _depth(position_deg: float | None, rig: RigSettings) -> float | None:
    return None if position_deg is None else round(rig.depth_at(position_deg), 3)


def _rounded(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else round(value, 3)


def newest_run(folder: Path) -> Path | None:
    """``folder`` when it holds a run, else the run directly below it that began last; None when there is none yet."""
    if (folder / PLAN_FILE).exists():
        return folder
    try:
        began = [(began_ns, name) for name in os.listdir(folder) if (began_ns := _began_ns(folder, name))]
    except OSError:
        return None
    return folder / max(began)[1] if began else None


def _began_ns(folder: Path, name: str) -> int | None:
    # asked 20 times a second for every run; a glob costs four times as much
    try:
        return os.stat(f"{folder}/{name}/{PLAN_FILE}").st_mtime_ns
    except OSError:
        return None


class Follower:
    """What one page has been shown so far.

    folder : of a run or of runs; it need not be there yet.
    now_s : seconds since 1970.
    """

    def __init__(self, folder: Path, now_s: Callable[[], float] = time.time) -> None:
        self._folder, self._now_s = folder, now_s
        self._run: _Run | None = None

    def look(self) -> Snapshot:
        """The present moment; its curves begin where those of the last call ended, or anew with a new run."""
        try:
            path = newest_run(self._folder)
            if path is None:
                self._run = None
                return Snapshot(str(self._folder))
            if self._run is None or self._run.path != path:
                self._run = _Run(path, *read_run(path))
            return self._run.look(self._now_s())
        except RecordingError as error:
            facts = self._run.facts if self._run else None
            return Snapshot(str(self._folder), run=facts, trouble=str(error))


class _Run:
    """One run of those that are followed."""

    def __init__(self, path: Path, facts: RunFacts, rig: RigSettings) -> None:
        self.path, self.facts, self._rig = path, facts, rig
        self._tail = LogTail(path / "log.csv")
        self._kappa = KappaTail(path)
        self._row: Row | None = None
        self._largest_n, self._across_n = largest_forces(path)
        self._weighed, self._weighed_at = "", (-1, "")
        self._turns = self._late_turns = 0
        self._latest_s = 0.0

    def look(self, now_s: float) -> Snapshot:
        ended = read_ending(self.path, self.facts.repetitions)  # before the log: nothing comes after the end
        rows = self._tail.new_rows()
        self._row = rows[-1] if rows else self._row
        for row in rows:
            self._count(row)
        modified_s = self._tail.modified_s()
        return Snapshot(
            folder=str(self.path),
            run=self.facts,
            curves=curves_of(rows, self._rig) if rows else Curves(),
            phase=self._row.phase if self._row else "",
            repetition=self._row.repetition if self._row else 0,
            presses_done=ended.presses_done if ended else self._done(),
            largest_n=round(self._largest_n, 3),
            largest_across_n=round(self._across_n, 3),
            turns=self._turns,
            late_turns=self._late_turns,
            latest_ms=round(1e3 * self._latest_s, 1),
            frame=f"{self._row.repetition}-{self._row.frame_index}" if self._row and self._row.frame_index >= 0 else "",
            age_s=None if modified_s is None else max(0.0, now_s - modified_s),
            weighed=self._told(),
            kappa=self._kappa.look(),
            stop_requested=stop_requested(self.path),
            ended=ended,
        )

    def _count(self, row: Row) -> None:
        along_n, across_n = forces_of(row)
        self._largest_n, self._across_n = max(self._largest_n, along_n), max(self._across_n, across_n)
        if row.late_s is not None:
            self._turns += 1
            self._late_turns += row.late_s >= LATE_PERIODS * self._rig.period_s
            self._latest_s = max(self._latest_s, row.late_s)

    def _told(self) -> str:
        at = (self._row.repetition, self._row.phase) if self._row else (-1, "")
        if at != self._weighed_at:  # a line comes with the end of a press
            self._weighed_at, found = at, weighed(self.path)
            number = max(found, default=0)
            self._weighed = f"press {number} by its depth: {found[number]}" if found else ""
        return self._weighed

    def _done(self) -> int:
        if self._row is None:
            return 0
        return max(0, self._row.repetition - (self._row.phase not in ("pause", "done")))
