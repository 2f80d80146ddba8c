"""What is shown of a run that begins, goes on, ends, and is followed by the next."""

from __future__ import annotations

import os

import numpy as np
import pytest

from emg2vsa.devices.protocols import Measurements
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK
from emg2vsa.live.follow import Follower, newest_run
from emg2vsa.rig.executor.stop_requests import request_stop


@pytest.fixture
def follower(runs):
    return Follower(runs)


def test_nothing_there_yet(follower, runs):
    moment = follower.look()
    assert (moment.run, moment.trouble, moment.folder) == (None, "", str(runs))
    runs.mkdir()
    (runs / "S1_0_modular").mkdir()
    assert follower.look().run is None


def test_facts_of_the_run(follower, begin, runs):
    begin("S1_30_high-stiffness")
    run = follower.look().run
    assert (run.name, run.specimen, run.angle_deg) == ("S1_30_high-stiffness", "S1", 30.0)
    assert (run.repetitions, run.f_contact_n, run.f_max_n, run.force_limit_n) == (3, 0.5, 7.0, 10.0)
    assert (run.full_preset, run.stiffness_percent, run.emulated) == (3000 * DEG_PER_TICK, (20.0, 80.0), False)
    assert run.over_bytes
    assert run.stiffness_nm_per_rad == ()
    for told, over_bytes in (("{}", False), ('{"over_bytes": true}', True)):
        (runs / run.name / "emulated.json").write_text(told)
        run = Follower(runs).look().run
        assert (run.emulated, run.over_bytes) == (True, over_bytes)


def test_curves_in_their_units(follower, begin, row):
    begin("run").row(row(2.5))
    curves = follower.look().curves
    assert curves.time_s == [2.5]
    assert (curves.raw_n, curves.filtered_n) == ([1.5], [1.25])
    assert curves.preset == [round(600 * DEG_PER_TICK, 3)]
    assert curves.measured_preset == [round((1400 - 200) / 2 * DEG_PER_TICK, 3)]
    # 0.2 mm per degree, 32768 ticks a turn, home at 100
    np.testing.assert_allclose(curves.depth_mm, [1000 * 0.2 * 360 / 32768], atol=5e-4)
    np.testing.assert_allclose(curves.shaft_mm, [900 * 0.2 * 360 / 32768], atol=5e-4)


def test_what_a_turn_did_not_measure_is_none(follower, begin, row):
    nothing = dict.fromkeys(("filtered_n", "position_deg", "preset", "at"))
    begin("run").row(row(force_n=float("nan"), **nothing))
    curves = follower.look().curves
    assert (curves.raw_n, curves.filtered_n, curves.preset) == ([None], [None], [None])
    assert (curves.measured_preset, curves.depth_mm, curves.shaft_mm) == ([None], [None], [None])


def test_one_motor_alone_has_no_preset_that_could_be_measured(follower, begin, row):
    begin("run").row(row(at=Measurements((20.0,), 11.0), currents_a=(0.25,)))
    curves = follower.look().curves
    assert (curves.measured_preset, curves.shaft_mm) == (
        [None],
        [round(2.2 - 20 * DEG_PER_TICK, 3)],
    )


def test_rows_come_once_and_the_state_stays(follower, begin, row):
    record = begin("run")
    record.row(row(0.1, phase="load", repetition=2, frame_index=4))
    first, second = follower.look(), follower.look()
    assert first.curves.time_s == [0.1]
    assert second.curves.time_s == []
    assert (second.phase, second.repetition, second.frame) == (first.phase, first.repetition, first.frame)
    assert (first.phase, first.repetition, first.frame) == ("load", 2, "2-4")
    record.row(row(0.2, phase="pause", repetition=2))
    assert follower.look().frame == ""


def test_only_the_newest_seconds_of_a_long_run_are_shown(follower, begin, row):
    record = begin("run")
    for second in range(40):
        record.row(row(float(second)))
    assert follower.look().curves.time_s == [float(second) for second in range(24, 40)]


def test_age_since_the_log_last_grew(begin, row, runs):
    begin("run").row(row())
    os.utime(runs / "run" / "log.csv", (1000.0, 1000.0))
    assert Follower(runs, now_s=lambda: 1002.5).look().age_s == 2.5
    assert Follower(runs, now_s=lambda: 999.0).look().age_s == 0  # the clock was set back


def test_the_end_is_told_once_it_is_known(follower, begin, ended):
    record = begin("run")
    assert follower.look().ended is None  # ended.json says "killed" as long as the run goes on
    record.end(ended())
    assert follower.look().ended.title == "Completed"


def test_it_goes_on_to_the_next_run_with_new_curves(follower, begin, row, ended, runs):
    first = begin("b")
    first.row(row(1.0))
    follower.look()
    first.end(ended())
    begin("a").row(row(0.5))
    os.utime(runs / "b" / "plan.json", (1000.0, 1000.0))
    moment = follower.look()
    assert (moment.run.name, moment.curves.time_s, moment.ended) == ("a", [0.5], None)


def test_the_folder_of_one_run_is_followed_alone(begin, runs):
    begin("a")
    begin("b")
    os.utime(runs / "a" / "plan.json", (1000.0, 1000.0))
    assert newest_run(runs / "a") == runs / "a"
    assert newest_run(runs) == runs / "b"


def test_a_request_to_stop_is_seen_by_every_page(follower, begin, runs):
    begin("run")
    assert not follower.look().stop_requested
    request_stop(runs / "run", "a test")
    assert follower.look().stop_requested
    assert Follower(runs).look().stop_requested


@pytest.mark.parametrize("damage", ["", "{", "[]", '{"plan": {}, "rig": {}}'])
def test_a_plan_that_cannot_be_read_is_said(follower, begin, runs, damage):
    begin("run")
    (runs / "run" / "plan.json").write_text(damage)
    assert "expected the plan of a run" in follower.look().trouble


def test_a_log_that_is_none_is_said_and_the_run_named(follower, begin, runs):
    begin("run")
    (runs / "run" / "log.csv").write_text("nothing of the kind\n")
    moment = follower.look()
    assert "expected the log of a run" in moment.trouble
    assert moment.run.name == "run"
