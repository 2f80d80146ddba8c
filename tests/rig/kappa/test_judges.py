"""Judges of presses: the same rows in the run's process and beside it, frames that are dropped, a process that dies."""

from __future__ import annotations

import json
import os
import shutil
import signal
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.rig.plans import known_calibration
from casr.frames import force_per_frame
from emg2vsa.calibration.online import NO_GAIN, WIDTH_REACHED
from emg2vsa.devices.protocols import Frame
from emg2vsa.errors import DeviceError
from emg2vsa.rig.kappa.judges import HOLD_S, SLOTS, Held, OwnProcess, SameProcess, stop_text, stop_word, write_about
from emg2vsa.rig.kappa.live_kappa import KappaPlan, KappaRow, last_rows, line_of, rows_of
from emg2vsa.worlds.tactile import PressSettings, TabulatedWorld, simulate_press

KAPPA = 3.35


class Press:
    """Frames at 20 a second and 200 forces a second, of a specimen whose area over force is known."""

    def __init__(self) -> None:
        made = simulate_press(PressSettings(stiffness_n_per_mm=KAPPA, world=TabulatedWorld()))
        n = int(made.truth.loading_frames[-1]) + 1
        line = made.timeline
        force = force_per_frame(line.log_force_n, line.log_frame_index, len(made.frames))[:n]
        chosen = [0, 1, 2, 3, 4, *range(int(np.argmax(force > 0.5)) - 1, n, 3)]
        self.camera = made.settings.camera
        self.frames = [Frame(0.05 * k, np.asarray(made.frames.read(i), np.uint8)) for k, i in enumerate(chosen)]
        self.time_s = np.arange(-0.02, 0.05 * len(chosen) + 0.03, 0.005)
        self.force_n = np.interp(self.time_s, 0.05 * np.arange(len(chosen)), force[chosen])
        self.peak_n = float(force.max())

    def shown_to(self, judge: SameProcess | OwnProcess, repetition: int = 1, *, wait: bool = False) -> list[str]:
        """What the judge said of stopping after each reading."""
        frames, said = list(self.frames), []
        for time_s, force_n in zip(self.time_s.tolist(), self.force_n.tolist(), strict=True):
            while frames and frames[0].time_s <= time_s:
                judge.frame(repetition, frames.pop(0))
            judge.force(time_s, force_n)
            said.append(judge.stop(repetition))
            while wait and judge._sent - judge._words[0] > 1:  # then no frame is dropped, however slow the machine is
                time.sleep(0.002)
        judge.press_over()
        return said


@pytest.fixture(scope="module")
def press() -> Press:
    return Press()


@pytest.fixture
def plan(press: Press) -> KappaPlan:
    return KappaPlan("known.json", known_calibration(), press.camera, None)


@pytest.fixture
def beside(plan: KappaPlan, press: Press, tmp_path: Path) -> Iterator[OwnProcess]:
    judge = OwnProcess(plan, tmp_path / "kappa.csv", press.frames[0].image.shape)
    yield judge
    judge.close()


def test_kappa_of_a_known_specimen_lies_in_its_interval_all_along(
    press: Press, plan: KappaPlan, tmp_path: Path
) -> None:
    judge = SameProcess(plan, tmp_path / "kappa.csv")
    assert set(press.shown_to(judge)) == {""}  # nobody asked to stop
    judge.close()
    rows = rows_of((tmp_path / "kappa.csv").read_text().partition("\n")[2])
    assert len(rows) == len(press.frames) == judge.tally.answered
    told = [row for row in rows if np.isfinite(row.kappa_n_per_mm)]
    assert told[0].judged_at_n < 2
    assert told[-1].force_n == pytest.approx(press.peak_n, abs=0.05)
    assert all(row.low_n_per_mm < KAPPA < row.high_n_per_mm for row in told)
    assert told[-1].half_width < 0.45
    (last,) = last_rows(tmp_path / "kappa.csv")
    np.testing.assert_equal(vars(last), vars(told[-1]))
    assert "N/mm, 95 %: " in last.told()


def test_a_process_of_its_own_says_the_same_and_asks_to_stop(press: Press, plan: KappaPlan, tmp_path: Path) -> None:
    plan = KappaPlan(plan.name, plan.calibration, plan.camera, stop_at=0.45)
    here = SameProcess(plan, tmp_path / "here.csv")
    said = press.shown_to(here)
    here.close()
    there = OwnProcess(plan, tmp_path / "there.csv", press.frames[0].image.shape)
    press.shown_to(there, wait=True)
    assert (tmp_path / "there.csv").exists()  # rows are written as they come
    end_s = time.monotonic() + 60
    while there.stop(1) == "" and time.monotonic() < end_s:
        time.sleep(0.01)
    assert there.stop(1).startswith(said[-1].partition(",")[0])
    assert there.stop(2) == ""
    there.close()
    assert (there.tally.dropped, there.tally.trouble) == (0, "")
    own, other = ((tmp_path / name).read_text() for name in ("here.csv", "there.csv"))
    mine, theirs = (rows_of(text.partition("\n")[2]) for text in (own, other))
    # domes are looked for when no frame waits, which is another moment there
    np.testing.assert_allclose([r.area or 0 for r in mine], [r.area or 0 for r in theirs], rtol=0.01)
    stopped = next(row for row in mine if row.stop)
    assert stopped.stop in (WIDTH_REACHED, NO_GAIN)
    assert stopped.half_width <= 0.45
    assert said[-1].startswith(stopped.stop)


def test_frames_beyond_the_slots_are_dropped_and_counted_and_nobody_waits(beside: OwnProcess, press: Press) -> None:
    assert beside.pid is not None
    os.kill(beside.pid, signal.SIGSTOP)
    try:
        longest_s = 0.0
        for k in range(3 * SLOTS):
            began_s = time.perf_counter()
            beside.frame(1, Frame(0.05 * k, press.frames[0].image))
            beside.force(0.05 * k + 0.02, 0.0)
            longest_s = max(longest_s, time.perf_counter() - began_s)
    finally:
        os.kill(beside.pid, signal.SIGCONT)
    assert longest_s < 5
    beside.close()
    assert beside.tally.frames == 3 * SLOTS
    assert beside.tally.dropped == 2 * SLOTS
    assert beside.tally.answered == SLOTS
    assert beside.tally.about()["latency"] is None


def test_more_readings_than_a_page_of_the_pipe_holds_make_nobody_wait(beside: OwnProcess, press: Press) -> None:
    assert beside.pid is not None
    os.kill(beside.pid, signal.SIGSTOP)
    try:
        longest_s = 0.0
        for k in range(4000):  # 1000 readings and 5 frames a second
            began_s = time.perf_counter()
            if k % 200 == 0:
                beside.frame(1, Frame(k / 1000, press.frames[0].image))
            beside.force(k / 1000, 0.0)
            longest_s = max(longest_s, time.perf_counter() - began_s)
    finally:
        os.kill(beside.pid, signal.SIGCONT)
    assert longest_s < 5
    beside.close()
    assert (beside.tally.trouble, beside.tally.dropped) == ("", 20 - SLOTS)
    assert beside.tally.answered == SLOTS


def test_readings_of_a_frame_that_was_dropped_come_with_the_next(beside: OwnProcess, press: Press) -> None:
    assert beside.pid is not None
    os.kill(beside.pid, signal.SIGSTOP)
    try:
        for k in range(SLOTS + 3):
            beside.frame(1, Frame(0.05 * k, press.frames[0].image))
            beside.force(0.05 * k + HOLD_S, 0.01 * k)
    finally:
        os.kill(beside.pid, signal.SIGCONT)
    end_s = time.monotonic() + 60
    while beside._words[0] < SLOTS and time.monotonic() < end_s:
        time.sleep(0.01)
    beside.frame(1, Frame(2.0, press.frames[0].image))
    beside.force(2.0 + HOLD_S, 1.0)
    sent = beside._readings[SLOTS % SLOTS, :4].tolist()
    assert [force_n for _, force_n in sent] == pytest.approx([0.16, 0.17, 0.18, 1.0])


def test_no_room_for_frames_is_said_before_the_first_press_and_leaves_nothing(
    plan: KappaPlan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    room, made, mkstemp = shutil.disk_usage("/dev/shm").total, [], tempfile.mkstemp

    def spied(**how: Any) -> tuple[int, str]:
        made.append(mkstemp(**how))
        return made[-1]

    monkeypatch.setattr(tempfile, "mkstemp", spied)
    with pytest.raises(DeviceError, match=r"the estimator: expected .* MB of shared memory for 16 frames"):
        OwnProcess(plan, tmp_path / "kappa.csv", (1024, 2 * room // 1024 // SLOTS))
    ((_, path),) = made
    assert not Path(path).exists()


def test_a_process_that_is_killed_ends_no_press(
    beside: OwnProcess, press: Press, plan: KappaPlan, tmp_path: Path
) -> None:
    assert beside.pid is not None
    os.kill(beside.pid, signal.SIGKILL)
    time.sleep(0.1)
    assert set(press.shown_to(beside)) == {""}
    press.shown_to(beside, repetition=2)
    beside.close()
    write_about(tmp_path, plan, beside.tally)
    about = json.loads((tmp_path / "kappa.json").read_text())
    assert about["frames"] == 2 * len(press.frames)
    assert about["dropped"] > 0
    assert about["answered"] == 0
    assert "ended" in about["trouble"]


def test_a_process_ends_with_the_one_that_started_it(beside: OwnProcess) -> None:
    beside.close()
    assert beside.tally.trouble == ""
    assert beside.tally.frames == 0


def test_a_calibration_that_cannot_be_used_is_said_before_the_first_press(press: Press, tmp_path: Path) -> None:
    calibration = known_calibration(quantity="no such quantity")
    with pytest.raises(DeviceError, match="the estimator: expected a process that starts, but found KeyError"):
        OwnProcess(KappaPlan("x", calibration, press.camera, None), tmp_path / "kappa.csv", (300, 300))


def test_a_frame_waits_for_the_readings_that_tell_its_force() -> None:
    held, image = Held(), np.zeros((2, 2), np.uint8)
    held.frame(1, Frame(1.0, image))
    held.force(1.0, 0.1)
    assert held.ready() == []
    held.force(1.0 + HOLD_S, 0.2)
    ((repetition, frame, readings),) = held.ready()
    assert (repetition, frame.time_s, [force for _, force in readings]) == (1, 1.0, [0.1, 0.2])
    held.frame(1, Frame(1.05, image))
    assert held.ready() == []
    assert len(held.ready(over=True)) == 1


def row(**changes: object) -> KappaRow:
    values = dict.fromkeys(("time_s", "force_n", "kappa_n_per_mm", "low_n_per_mm", "judged_at_n"), 1.0)
    whole = {"repetition": 3, "frame": 7, "presses": 2, "area": 12.5, "high_n_per_mm": float("inf")}
    other = {"half_width": 0.049, "reachable": 0.1, "cues": "area", "latency_s": float("nan")}
    return KappaRow(**(values | whole | other | {"stop": ""} | changes))  # type: ignore[arg-type]


def test_rows_read_back_as_they_were_written() -> None:
    written = [row(), row(area=None, note='pins lost, "again"'), row(stop=WIDTH_REACHED, kappa_n_per_mm=float("nan"))]
    np.testing.assert_equal(
        [vars(each) for each in rows_of("".join(map(line_of, written)))], [vars(each) for each in written]
    )
    with pytest.raises(ValueError, match="argument"):
        rows_of("1,2,3\n")


def test_why_a_press_stops_fits_into_one_word() -> None:
    word = stop_word(row(stop=WIDTH_REACHED))
    assert 0 < word < 2**63
    assert stop_text(word, 3) == "width reached, kappa to 4.9 %"
    assert stop_text(word, 4) == stop_text(0, 3) == ""
    assert stop_word(row()) == 0
    no_width = stop_word(row(stop=NO_GAIN, half_width=float("inf")))
    assert stop_text(no_width, 3) == f"{NO_GAIN}, kappa open to rigid"
    assert stop_text(stop_word(row(stop=NO_GAIN, half_width=1e9)), 3).endswith("kappa to 104857 %")


def test_an_interval_without_an_end_has_no_share() -> None:
    assert row(half_width=float("inf")).told().startswith("1 N/mm, 95 %: 1 to rigid; ")
    assert "1 to 2 (±5%)" in row(high_n_per_mm=2.0).told()
