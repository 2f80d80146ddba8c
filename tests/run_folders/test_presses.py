"""The presses of a run's folders, those without frames too."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import tifffile

from emg2vsa.rig.record.new_folder import EMULATED_FILE, PLAN_FILE
from emg2vsa.rig.record.press_counts import PRESSES_FILE
from emg2vsa.run_folders.presses import read_presses, run_notes, run_setup


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """Presses 1, 2 and 10 of a run; the second holds a force log alone. Other logs are no press."""
    folder = tmp_path / "monday-1"
    for name in ("press-001", "press-10"):
        (folder / name).mkdir(parents=True)
        tifffile.imwrite(folder / name / "frames.tif", np.zeros((3, 20, 20), np.uint8), photometric="minisblack")
    (folder / "press-002").mkdir()
    (folder / "press-002" / "force.csv").write_text("time_s,force_n,frame_index\n")
    (folder / "pressure-logs").mkdir()
    return folder


def test_a_press_without_frames_counts_and_says_so(run):
    presses = list(read_presses([run]))
    assert [press.frames is None for press in presses] == [False, True, False]
    assert "monday-1/press-002: expected images" in presses[1].problem.replace("\\", "/")


def test_a_run_without_any_frames_has_its_presses(run):
    for path in run.rglob("frames.tif"):
        path.unlink()
    assert [press.frames for press in read_presses([run])] == [None, None, None]


def test_a_press_tells_from_which_folder_it_comes(run, tmp_path):
    again = run.rename(tmp_path / "tuesday-1")
    (run / "press-001").mkdir(parents=True)
    presses = list(read_presses([run, again]))
    assert [press.mounting for press in presses] == [1, 2, 2, 2]
    assert [press.repetition for press in presses] == [1, 2, 3, 4]


def test_errors_of_a_press_name_its_run(run):
    first = next(read_presses([run]))
    assert first.frames is not None
    assert first.frames.name == "monday-1/press-001"


def test_what_the_rig_rejected_is_not_scored_and_what_it_doubts_is_told(run):
    (run / PRESSES_FILE).write_text("repetition,verdict,why\n1,rejected,encoders broken\n10,doubtful,2 % lost\n")
    (run / "ended.json").write_text('{"how": "completed"}')
    presses = list(read_presses([run]))
    assert [press.frames is None for press in presses] == [True, True, False]
    assert presses[0].problem == "monday-1, press 1 was rejected by the rig: encoders broken"
    assert run_notes([run]) == ("monday-1, press 10 is doubtful: 2 % lost",)


def test_every_folder_is_a_mounting_unless_the_rig_says_that_it_goes_on(run, tmp_path):
    folders = [run, *(Path(shutil.copytree(run, tmp_path / f"S1_0_modular{end}")) for end in ("", "-2", "_mounting-2"))]
    for folder, mounting in zip(folders[1:], (1, 1, 2), strict=True):
        (folder / PLAN_FILE).write_text(json.dumps({"plan": {"mounting": mounting}}))
    assert [press.mounting for press in read_presses(folders)] == [1] * 3 + [2] * 6 + [3] * 3
    (run / PLAN_FILE).write_text('{"plan": {"mounting": [1]}}')
    assert [press.mounting for press in read_presses(folders)] == [1] * 3 + [2] * 6 + [3] * 3


def test_a_folder_that_is_gone_has_no_presses(tmp_path):
    assert list(read_presses([tmp_path / "taken away"], None)) == []


@pytest.mark.parametrize(
    ("emulated", "document", "expected"),
    [
        (False, {"plan": {"order": 3}, "clock": {"zero_utc": "1970-01-02T00:00:00+00:00"}}, 86400.0),
        (True, {"plan": {"order": 3}, "clock": {"zero_utc": "1970-01-02T00:00:00+00:00"}}, 3.0),
        (True, {"plan": {"order": None}}, np.nan),
        (False, {"plan": {"order": 3}, "clock": {"zero_utc": "yesterday"}}, np.nan),
        (False, None, np.nan),
    ],
)
def test_a_press_tells_when_its_folder_was_begun(run, emulated, document, expected):
    """An emulated run has the date of its experiment alone, so that its place there counts."""
    if document is not None:
        (run / PLAN_FILE).write_text(json.dumps(document))
    if emulated:
        (run / EMULATED_FILE).write_text("{}")
    assert [press.pressed_at for press in read_presses([run])] == pytest.approx([expected] * 3, nan_ok=True)


def test_plans_and_camera_files_tell_how_runs_were_made_each_value_once(run, tmp_path):
    camera = tmp_path / "camera.toml"
    camera.write_text("[camera]\nframe_rate_hz = 20\n[sensor]\npin_length_mm = 3.0\n")
    again = tmp_path / "tuesday-1"
    again.mkdir()
    for folder, f_max_n in ((run, 7.0), (again, 5.0)):
        plan = {
            "plan": {"f_max_n": f_max_n, "travel_mm": 15.0, "schedule": {}},
            "rig": {"rate_hz": 200.0, "travel_mm": 20},
        }
        (folder / PLAN_FILE).write_text(json.dumps(plan))
    (again / "camera.toml").write_text("[camera]\nframe_rate_hz = 25.0\n")
    assert run_setup([run, again], camera) == {
        "f_max_n": (7.0, 5.0), "travel_mm": (15.0,), "rate_hz": (200.0,), "frame_rate_hz": (20.0, 25.0),
        "pin_length_mm": (3.0,),
    }  # fmt: skip


@pytest.mark.parametrize("text", ["", "[1]", "{", '{"plan": 3, "rig": {"rate_hz": "fast"}}'])
def test_a_folder_that_tells_nothing_has_no_setup(run, text):
    (run / PLAN_FILE).write_text(text)
    (run / "camera.toml").write_text("camera =")
    assert run_setup([run]) == {}
