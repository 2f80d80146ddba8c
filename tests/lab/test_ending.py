"""The end of a run in words."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from emg2vsa.devices.clock import LoopTiming
from emg2vsa.lab.pressed import summary, told
from emg2vsa.rig.record.ended import Ended
from emg2vsa.rig.rig_settings import RigSettings

WHOLE = Ended(
    how="completed", cause="", why="", phase="home", repetition=0, time_s=12.34, at="2026-01-01T00:00:00",
    repetitions_done=2, rows=2468, retracted=True, deactivated=True,
)  # fmt: skip
GUARD = dataclasses.replace(
    WHOLE, how="guard", cause="untrusted force", why="saturated", phase="press", repetition=2, repetitions_done=1,
    retracted=False, deactivated=False, notes=("camera: 3 frames dropped",),
)  # fmt: skip


def test_a_whole_run_is_told_line_by_line(tmp_path: Path) -> None:
    assert told(WHOLE, 2, tmp_path, RigSettings()).splitlines() == [
        "completed: 2 of 2 presses, 12.3 s",
        "left: probe retracted, motors off",
        f"recorded: {tmp_path / 'log.csv'} (rows: 2468)",
    ]


def test_what_was_left_unsafe_is_told(tmp_path: Path) -> None:
    assert told(GUARD, 2, tmp_path, RigSettings()).splitlines()[:3] == [
        "guard: untrusted force in press of press 2 (saturated); 1 of 2 presses, 12.3 s",
        "left: probe NOT retracted, motors NOT confirmed off",
        "note: camera: 3 frames dropped",
    ]


def test_the_timing_of_the_loop_has_a_column_each(tmp_path: Path) -> None:
    ended = dataclasses.replace(WHOLE, peak_force_n=6.789, timing=LoopTiming(2468, 1e-4, 5e-4, 2e-3, 0.0125, 7))
    *_, force, _, head, row = told(ended, 2, tmp_path, RigSettings()).splitlines()
    assert force == "largest force: 6.79 N"
    assert head.split() == ["control", "loop", "turns", "median", "99", "%", "99.9", "%", "largest", "overruns"]
    assert row.split()[-6:] == ["2468", "0.100", "0.500", "2.000", "12.500", "7"]


def test_who_stopped_a_run_needs_no_reason() -> None:
    stopped = dataclasses.replace(WHOLE, how="stopped", cause="SIGTERM", why="a signal", phase="home")
    assert summary(stopped, 2) == "stopped: SIGTERM in home; 2 of 2 presses, 12.3 s"
