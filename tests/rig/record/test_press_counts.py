"""Counts of presses and folders of runs."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from emg2vsa.devices.protocols import ForceCounts, Frame, Measurements
from emg2vsa.errors import DataError
from emg2vsa.rig.record.new_folder import EMULATED_FILE, how_ended, new_folder, presses_done, presses_left
from emg2vsa.rig.record.press_counts import HEADER, PRESSES_FILE, PressTally, largest_forces, line_of, verdicts
from emg2vsa.rig.record.run_log import Row
from emg2vsa.rig.rig_settings import LossSettings, RigSettings

BEFORE = ForceCounts(records=1000, lost=7)
AT_REST = Measurements((0.0, 0.0), 0.0)
FRAME = np.zeros((2, 2), np.uint8)


def row(time_s: float, late_s: float = 0.0, force_n: float | None = 1.0, **changes: float) -> Row:
    blank = Row(time_s, 1, "load", time_s, force_n, 1.0, 0.0, 0.0, AT_REST, (0.0, 0.0), -1, late_s)
    return blank._replace(**changes)


def press(late: int = 0, missing: int = 0, lost: int = 0, frames_missing: int = 0, rig: RigSettings | None = None):
    """200 turns, 500 records and 40 frames, less what is named."""
    tally = PressTally(3, 0.0, rig or RigSettings(), BEFORE)
    for turn in range(200):
        if turn == 0 or turn > missing:
            tally.row(row(turn / 200, 0.004 if turn >= 200 - late else 0.0))
    for frame in range(40 - frames_missing):
        tally.frame(Frame(frame / 20, FRAME, dropped=frames_missing if frame == 1 else 0))
    tally.turn_back(1.0, ForceCounts(1500 - lost, 7 + lost))
    return tally.counts()


def test_a_whole_press_is_ok():
    found = press()
    assert (found.verdict, found.why, found.turns, found.force_records, found.frames) == ("ok", "", 200, 500, 40)


@pytest.mark.parametrize(
    ("lost", "verdict", "why"),
    [
        ({"late": 2}, "ok", ""),
        ({"late": 3}, "doubtful", "1.5 % of its turns were late, by up to 4 ms: the computer was busy"),
        ({"late": 120}, "rejected", "60 % of its turns were late, by up to 4 ms: the computer was busy"),
        ({"missing": 10}, "doubtful", "5 % of its turns are missing: the computer was busy, or a device slow"),
        ({"missing": 60}, "rejected", "30 % of its turns are missing: the computer was busy, or a device slow"),
        ({"lost": 25}, "doubtful", "5 % of its records of the force sensor were lost: look at its network and cable"),
        ({"lost": 250}, "rejected", "50 % of its records of the force sensor were lost: look at its network and cable"),
        ({"frames_missing": 1}, "ok", ""),
        ({"frames_missing": 4}, "doubtful", "10 % of its frames are missing: look at the camera and its cable"),
        ({"frames_missing": 20}, "rejected", "50 % of its frames are missing: look at the camera and its cable"),
    ],
)
def test_what_is_missing_makes_it_doubtful_or_rejects_it(lost, verdict, why):
    found = press(**lost)
    assert (found.verdict, found.why) == (verdict, why)


def test_the_rig_file_sets_the_limits():
    strict = RigSettings(losses=LossSettings(late_turns_percent=(0.0, 0.0)))
    assert press(late=1, rig=strict).verdict == "rejected"


def test_frames_missing_before_the_first_are_of_no_press():
    tally = PressTally(1, 0.0, RigSettings(), BEFORE)
    tally.frame(Frame(0.0, FRAME, dropped=9))
    assert tally.counts().frames_missing == 0


def test_what_comes_after_the_turn_counts_for_the_largest_force_alone():
    tally = PressTally(1, 0.0, RigSettings(), BEFORE)
    tally.row(row(0.0))
    tally.turn_back(0.0, BEFORE)
    tally.row(row(0.5, 0.1, force_n=-8.0, fx_n=3.0, fy_n=4.0, fz_n=-8.0))
    tally.turn_back(0.6, ForceCounts(records=9999))
    found = tally.counts()
    assert (found.turns, found.late_turns, found.missing_turns, found.force_records) == (1, 0, 0, 0)
    assert (found.peak_force_n, found.peak_lateral_n) == (8.0, pytest.approx(5.0))


def test_a_force_that_is_no_number_is_no_largest_force():
    tally = PressTally(1, 0.0, RigSettings(), BEFORE)
    tally.row(row(0.0, force_n=float("nan"), fx_n=float("nan"), fy_n=0.0, fz_n=0.0))
    assert (tally.counts().peak_force_n, tally.counts().peak_lateral_n) == (0.0, 0.0)


def test_verdicts_come_back_and_half_a_line_is_passed_over(tmp_path: Path):
    lines = [line_of(press(late=late)) for late in (0, 3, 120)]
    (tmp_path / PRESSES_FILE).write_text(f"{HEADER}\n" + "".join(lines).replace("\n3,", "\n4,", 1)[:-5])
    found = verdicts(tmp_path)
    assert [verdict for verdict, _ in found.values()] == ["ok", "doubtful"]
    assert found[4][1].startswith("1.5 % of its turns were late, by up to 4 ms")
    assert verdicts(tmp_path / "none") == {}
    assert largest_forces(tmp_path / "none") == (0.0, 0.0)


@pytest.mark.parametrize("content", [b"", b"\xff\xfe", b"repetition,verdict\nx,ok\n1,good\n", b"a,b\n1,2\n"])
def test_another_file_says_nothing(tmp_path: Path, content: bytes):
    (tmp_path / PRESSES_FILE).write_bytes(content)
    assert verdicts(tmp_path) == {}
    assert largest_forces(tmp_path) == (0.0, 0.0)


def make(folder: Path, how: str | None, done: int = 10) -> None:
    folder.mkdir(parents=True)
    if how is not None:
        (folder / "ended.json").write_text(json.dumps({"how": how, "repetitions_done": done}))


def test_the_first_free_name(tmp_path: Path) -> None:
    runs = tmp_path / "runs"
    assert new_folder(runs, "S1_0_modular", 10, emulated=False) == runs / "S1_0_modular"
    for number, how in enumerate(("killed", "guard", None), start=1):
        make(runs / ("S1_0_modular" if number == 1 else f"S1_0_modular-{number}"), how, done=0)
        assert new_folder(runs, "S1_0_modular", 10, emulated=False) == runs / f"S1_0_modular-{number + 1}"
    assert presses_left(runs, "S1_0_modular", 10, emulated=False) == 10
    assert not (runs / "S1_0_modular-4").exists()
    assert new_folder(runs, "S1_30_modular", 10, emulated=False) == runs / "S1_30_modular"


@pytest.mark.parametrize("before", [(), (0,), (4, 0), (9, 3)])
def test_a_run_with_all_its_presses_is_refused(before: tuple[int, ...], tmp_path: Path) -> None:
    names = ["S1_0_modular", "S1_0_modular-2", "S1_0_modular-3"]
    for name, done in zip(names, before, strict=False):
        make(tmp_path / name, "guard", done)
    make(tmp_path / names[len(before)], "completed", 10 - min(10, sum(before)))
    assert presses_left(tmp_path, "S1_0_modular", 10, emulated=False) == 0
    with pytest.raises(
        DataError, match="expected a run that is still to do, but found one with all its presses"
    ) as caught:
        new_folder(tmp_path, "S1_0_modular", 10, emulated=False)
    assert caught.value.where == str(tmp_path / "S1_0_modular")


def test_a_trial_of_fewer_presses_counts_and_the_others_are_still_to_do(tmp_path: Path) -> None:
    make(tmp_path / "S1_0_modular", "completed", done=2)
    assert presses_left(tmp_path, "S1_0_modular", 10, emulated=False) == 8
    assert new_folder(tmp_path, "S1_0_modular", 10, emulated=False) == tmp_path / "S1_0_modular-2"


@pytest.mark.parametrize(("how", "done", "good"), [("rejected", 3, 2), ("guard", 2, 1), ("killed", 0, 2)])
def test_rejected_presses_do_not_count(how: str, done: int, good: int, tmp_path: Path) -> None:
    """Of a run that a guard ended the press under way does not count; a killed one has no count of its own."""
    make(tmp_path / "S1_0_modular", how, done)
    rows = "repetition,verdict,why\n1,ok,\n2,rejected,lost\n3,doubtful,late\n"
    (tmp_path / "S1_0_modular" / PRESSES_FILE).write_text(rows)
    assert presses_left(tmp_path, "S1_0_modular", 10, emulated=False) == 10 - good


@pytest.mark.parametrize("text", ["", "{", "[]", "{}", "3"])
def test_an_ending_that_cannot_be_read_is_none(text: str, tmp_path: Path) -> None:
    (tmp_path / "ended.json").write_text(text)
    assert how_ended(tmp_path) is None
    assert presses_done(tmp_path) == 0


@pytest.mark.parametrize("emulated", [False, True])
def test_runs_of_the_other_kind_do_not_count(emulated: bool, tmp_path: Path) -> None:
    make(tmp_path / "S1_0_modular", "completed")
    if not emulated:
        (tmp_path / "S1_0_modular" / EMULATED_FILE).write_text("{}")
    assert presses_left(tmp_path, "S1_0_modular", 10, emulated=emulated) == 10
    assert presses_left(tmp_path, "S1_0_modular", 10, emulated=not emulated) == 0
    assert new_folder(tmp_path, "S1_0_modular", 10, emulated=emulated) == tmp_path / "S1_0_modular-2"
