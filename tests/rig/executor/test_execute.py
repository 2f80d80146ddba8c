"""A run without faults: phases, stiffness, recordings and the beat of the loop."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable
from dataclasses import asdict, replace
from itertools import groupby, pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.rig.fault_case import read_log
from casr.frame_files import open_frames, read_force_log
from emg2vsa.devices.clock import LoopTiming
from emg2vsa.devices.protocols import ForceCounts, Rating
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK
from emg2vsa.errors import DeviceError, ScheduleError, SettingError
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.record.new_folder import good_presses
from emg2vsa.rig.record.press_counts import verdicts
from emg2vsa.rig.record.run_log import Row
from emg2vsa.rig.rig_settings import RigSettings

PRESS = ["approach", "contact", "load", "retract", "pause"]


def phases(rows: list[Row]) -> list[tuple[int, str]]:
    return [key for key, _ in groupby((row.repetition, row.phase) for row in rows)]


def test_ten_repetitions_complete(bench: Any, plan_of: Callable[..., RunPlan], tmp_path: Path) -> None:
    ended = bench.run(tmp_path, plan_of(repetitions=10))
    assert (ended.how, ended.cause, ended.repetitions_done) == ("completed", "", 10)
    assert (ended.retracted, ended.deactivated, ended.notes) == (True, True, ())
    rows = read_log(tmp_path / "log.csv")
    expected = [(0, "home"), *((n, phase) for n in range(1, 11) for phase in PRESS), (10, "done"), (10, "escape")]
    assert phases(rows) == expected
    assert len(rows) == ended.rows == len(bench.forces_n)
    assert bench.calls[0] == "activate"
    assert bench.calls[-1] == "deactivate"


def test_a_repetition_as_planned(bench: Any, plan_of: Callable[..., RunPlan], rig: RigSettings, tmp_path: Path) -> None:
    bench.run(tmp_path, plan_of(repetitions=1, pause_s=2.0))
    rows = read_log(tmp_path / "log.csv")
    of = {phase: [row for row in rows if row.phase == phase] for phase in PRESS}
    assert of["contact"][0].filtered_n == pytest.approx(0.5, abs=0.13)  # one turn of 5 mm/s into 5 N/mm
    assert of["retract"][0].filtered_n == pytest.approx(7.0, abs=0.13)
    assert len({row.position_deg for row in of["contact"]}) == 1
    assert of["pause"][-1].time_s - of["pause"][0].time_s == pytest.approx(2.0, abs=0.006)
    for phase, sign in (("approach", 1), ("load", 1), ("retract", -1)):
        depth = [rig.depth_at(row.position_deg or 0) for row in of[phase]]
        speeds = np.diff(depth) * rig.rate_hz
        assert np.mean(speeds[:-1]) == pytest.approx(sign * 5.0, rel=0.02)
    turns_s = [row.time_s for row in rows if row.phase != "escape"]
    assert np.diff(turns_s) == pytest.approx(0.005, abs=1e-5)


def test_stiffness_follows_the_force(bench: Any, plan_of: Callable[..., RunPlan], tmp_path: Path) -> None:
    plan = plan_of()
    bench.run(tmp_path, plan)
    loading = [row for row in read_log(tmp_path / "log.csv") if row.phase == "load"]
    edges, presets = plan.schedule.step_force_n, plan.schedule.exported
    for row in loading:
        inside = [p for low, p in zip(edges[:-1], presets, strict=True) if low <= (row.filtered_n or 0) or low == 0.5]
        assert row.preset == inside[-1] * DEG_PER_TICK
    assert {row.preset for row in loading} == set((presets * DEG_PER_TICK).tolist())
    for row in loading:
        assert row.at.motors_deg == (row.position_deg + row.preset, row.position_deg - row.preset)
        assert row.currents_a == (0.1, -0.09)


def test_an_earlier_step_does_not_come_back_while_loading(bench: Any, tmp_path: Path) -> None:
    quiet, count = bench._force_n, iter(range(10**6))
    bench._force_n = lambda: quiet() + (0.3 if next(count) % 2 else -0.3) * (quiet() > 1)
    bench.run(tmp_path)
    for repetition in (1, 2):
        rows = [r for r in read_log(tmp_path / "log.csv") if (r.repetition, r.phase) == (repetition, "load")]
        presets = [row.preset or 0 for row in rows]
        assert any(a.filtered_n > b.filtered_n for a, b in pairwise(rows))
        assert presets == sorted(presets)


def test_the_filtered_force_decides(bench: Any, rig: RigSettings, tmp_path: Path) -> None:
    bench.run(tmp_path, rig=replace(rig, filter_samples=5))
    rows = [row for row in read_log(tmp_path / "log.csv") if row.phase != "escape"]
    raw = [row.force_n for row in rows]
    assert [row.filtered_n for row in rows[4:]] == pytest.approx(
        [np.mean(raw[n - 4 : n + 1]) for n in range(4, len(raw))], abs=2e-6
    )
    assert max(row.force_n for row in rows) > max(row.filtered_n for row in rows) >= 7.0


def test_a_rigid_motor_has_no_stiffness(bench: Any, plan_of: Callable[..., RunPlan], tmp_path: Path) -> None:
    assert bench.run(tmp_path, plan_of(condition="high-stiffness", f_max_n=2.0)).how == "completed"
    assert {preset for _, preset in bench.sent} == {0}


def test_a_constant_stiffness_is_constant(bench: Any, plan_of: Callable[..., RunPlan], tmp_path: Path) -> None:
    plan = plan_of(condition="constant-mean")
    assert bench.run(tmp_path, plan).how == "completed"
    rows = [row for row in read_log(tmp_path / "log.csv") if row.phase in ("contact", "load", "retract")]
    assert {row.preset for row in rows} == {plan.schedule.exported[0] * DEG_PER_TICK}


def test_each_press_is_readable_as_frames(bench: Any, tmp_path: Path) -> None:
    bench.run(tmp_path)
    rows = read_log(tmp_path / "log.csv")
    for repetition in (1, 2):
        frames = open_frames(tmp_path / f"press-{repetition:03d}")
        last = max(row.frame_index for row in rows if row.repetition == repetition)
        assert len(frames.force_n) == last + 1 > 10


def test_without_a_camera_there_are_no_frames(bench: Any, tmp_path: Path) -> None:
    assert bench.run(tmp_path, camera=False).how == "completed"
    assert {row.frame_index for row in read_log(tmp_path / "log.csv")} == {-1}
    assert not list(tmp_path.glob("press-*"))


def test_a_run_that_ends_with_a_force_at_home_is_not_completed(bench: Any, tmp_path: Path) -> None:
    quiet = bench._force_n
    bench._force_n = lambda: quiet() + (0.6 if bench.clock.now_s() > 2.8 and quiet() == 0 else 0.0)
    ended = bench.run(tmp_path)
    assert (ended.how, ended.cause, ended.repetitions_done) == ("rejected", "not retracted", 2)
    assert (ended.retracted, ended.deactivated, ended.last_force_n) == (False, True, 0.6)
    assert "less than 0.5 N at the retracted position" in ended.why
    assert verdicts(tmp_path) == {1: ("ok", ""), 2: ("rejected", "the probe was not retracted after it")}
    assert good_presses(tmp_path) == 1


def test_a_run_with_a_press_that_is_not_whole_is_not_completed(bench: Any, tmp_path: Path) -> None:
    bench.counts = lambda: ForceCounts(records=round(400 * bench.clock.now_s()), lost=round(200 * bench.clock.now_s()))
    ended = bench.run(tmp_path)
    assert (ended.how, ended.cause, ended.repetitions_done) == ("rejected", "press", 2)
    assert ended.why.startswith("press 1 is rejected: ")


def test_the_largest_force_is_told(bench: Any, tmp_path: Path) -> None:
    ended = bench.run(tmp_path)
    assert ended.peak_force_n == pytest.approx(max(bench.forces_n))
    assert ended.last_force_n == 0.0


def test_the_end_is_on_disk(bench: Any, tmp_path: Path) -> None:
    ended = bench.run(tmp_path)
    stored = json.loads((tmp_path / "ended.json").read_text())
    assert stored == asdict(ended) | {"notes": list(ended.notes)}
    assert stored["at"].startswith("2026-03-01T09:30:0")
    assert stored["timing"]["overruns"] == 0
    assert stored["timing"]["largest_s"] < 1e-9
    assert json.loads((tmp_path / "plan.json").read_text())["plan"]["angle_deg"] == 30.0


def test_a_killed_run_says_so_by_itself(bench: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("emg2vsa.rig.executor.execute._finish", lambda *_: None)  # kill -9 comes before the way out
    bench.run(tmp_path)
    assert json.loads((tmp_path / "ended.json").read_text())["how"] == "killed"


def test_a_run_is_never_overwritten(bench: Any, new_bench: Any, tmp_path: Path) -> None:
    bench.run(tmp_path)
    second = new_bench()
    with pytest.raises(DeviceError, match=r"ended\.json"):
        second.run(tmp_path)
    assert second.calls == []


@pytest.mark.parametrize(("changes", "error"), [({"f_max_n": 12.0}, SettingError), ({"specimen": "S2"}, ScheduleError)])
def test_nothing_is_sent_for_a_plan_beyond_limits(
    bench: Any, plan_of: Callable[..., RunPlan], tmp_path: Path, changes: dict[str, Any], error: type[Exception]
) -> None:
    with pytest.raises(error):
        bench.run(tmp_path / "run", plan_of(**changes))
    assert bench.calls == []
    assert not (tmp_path / "run").exists()


def test_nothing_is_sent_where_the_force_limit_is_beyond_the_sensor(bench: Any, tmp_path: Path) -> None:
    bench.rating = Rating((50.0, 50.0, 8.0), (1.0, 1.0, 1.0))
    with pytest.raises(
        SettingError,
        match=r"rig\.guards\.force_n: expected at most 8 N, the rating of the force "
        r"sensor",
    ):
        bench.run(tmp_path / "run")
    assert bench.calls == []


def test_a_signal_handler_needs_only_to_set_a_name(bench: Any, tmp_path: Path) -> None:
    came: list[str] = []
    before = signal.signal(signal.SIGTERM, lambda number, frame: came.append(signal.Signals(number).name))
    try:
        counts = iter(range(10**6))
        bench.stop = lambda: (signal.raise_signal(signal.SIGTERM) if next(counts) == 100 else None) or "".join(came)
        ended = bench.run(tmp_path)
    finally:
        signal.signal(signal.SIGTERM, before)
    assert (ended.how, ended.cause, ended.deactivated) == ("stopped", "SIGTERM", True)
    assert bench.sent[-1][0] == 0


def test_a_busy_computer_is_named_beside_what_seems_lost(
    new_bench: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    busy = LoopTiming(1000, 0.0, 0.0, 0.0, 0.0, 3, late=11, latest_s=0.0123)
    monkeypatch.setattr("emg2vsa.devices.clock.Beat.timing", lambda beat: busy)
    said = "The control loop was late in 11 of 1000 turns, by up to 12 ms: the computer was busy."
    bench = new_bench(fault="dead actuator", fault_s=2.0)
    ended = bench.run(tmp_path / "lost")
    assert ended.cause == "lost device"
    assert said in ended.why
    whole = new_bench().run(tmp_path / "whole")
    assert (whole.how, whole.why) == ("completed", "")
    assert any(note.startswith(said) for note in whole.notes)


def test_what_is_lost_of_a_press_stands_in_its_folder(bench: Any, tmp_path: Path) -> None:
    # at the beginning, the turn and the end of each press
    counts = iter([ForceCounts(n) for n in (0, 1000, 1200, 1300)] + [ForceCounts(2250, 50)] * 2)
    bench.counts = lambda: next(counts)
    ended = bench.run(tmp_path / "run")
    why = "5 % of its records of the force sensor were lost: look at its network and cable"
    assert verdicts(tmp_path / "run") == {1: ("ok", ""), 2: ("doubtful", why)}
    assert (ended.how, ended.notes) == ("completed", (f"press 2 is doubtful: {why}",))
    assert read_force_log(tmp_path / "run" / "press-002" / "force.csv").notes == (
        f"the recorder of the press says doubtful: {why}",
    )
    assert read_force_log(tmp_path / "run" / "press-001" / "force.csv").notes == ()
