"""Schedules on disk: exact round trips, one answer to every corruption."""

from __future__ import annotations

import dataclasses
import json
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from emg2vsa.errors import ScheduleError
from emg2vsa.profiles import Profile, Profiles, errors_of
from emg2vsa.schedule_files import read_csv, read_json, write_csv, write_json, write_schedule
from emg2vsa.schedules import CONDITIONS, Schedule
from emg2vsa.schedules.build import build_schedules
from emg2vsa.settings import ScheduleSettings

Write = Callable[[Path, Schedule], None]
Read = Callable[[Path], Schedule]
BOTH = pytest.mark.parametrize(
    ("write", "read", "name"), [(write_csv, read_csv, "s.csv"), (write_json, read_json, "s.json")]
)


def schedule_of(
    a: float = 42e-6, b: float = 20e-6, note: str = "", *, interval: bool = True, **changes: Any
) -> Schedule:
    force = np.linspace(0.5, 7, 100)
    presses = np.array([[[a + 0.1 * b, 0.9 * b], [a - 0.1 * b, 1.1 * b], [a, b]]])
    profile = Profile(
        "S1", 7.63, a, b, force, a + b * np.log(force), "measured", 10, np.full(100, np.nan), np.ones((1, 2))
    )
    profiles = Profiles(
        profiles=(profile,), new=None, weight_alpha=float("nan"), bracket=None, new_measured=None, new_error=None,
        leave_one_out=(), participant="", unit="V", notes=(),
        errors=errors_of(presses, ["S1"], "press") if interval else None,
    )  # fmt: skip
    options: dict[str, Any] = {"conditions": ("modular",)} | changes
    (schedule,) = build_schedules(profiles, ScheduleSettings(**options), {"study": "palpation", "note": note})
    return schedule


def assert_same(one: Schedule, other: Schedule) -> None:
    for field in dataclasses.fields(Schedule):
        first, second = getattr(one, field.name), getattr(other, field.name)
        if isinstance(first, np.ndarray):
            assert first.dtype == second.dtype
            assert first.tobytes() == second.tobytes()
        else:
            assert first == second


@BOTH
@settings(max_examples=40, deadline=None)
@given(
    a=st.floats(-1, 1),
    b=st.floats(1e-3, 1),
    note=st.text(),
    percent=st.tuples(st.floats(0, 49), st.floats(50, 100)),
    step_n=st.floats(0.01, 3),
    gear=st.floats(0.01, 10),
    condition=st.sampled_from(CONDITIONS),
    interval=st.booleans(),
)
def test_round_trip(
    write: Write, read: Read, name: str, a: float, b: float, note: str, percent: tuple[float, float], step_n: float,
    gear: float, condition: str, interval: bool,
) -> None:  # fmt: skip
    schedule = schedule_of(
        a,
        b,
        note,
        interval=interval,
        stiffness_percent=percent,
        step_n=step_n,
        gear_mm_per_degree=gear,
        conditions=(condition,),
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, name)
        write(path, schedule)
        assert_same(read(path), schedule)


@BOTH
@pytest.mark.parametrize("interval", [True, False])
def test_same_schedule_same_bytes(write: Write, read: Read, name: str, tmp_path: Path, interval: bool) -> None:
    write(tmp_path / name, schedule_of(interval=interval))
    first = (tmp_path / name).read_bytes()
    write(tmp_path / name, read(tmp_path / name))
    assert (tmp_path / name).read_bytes() == first


WITHOUT_INTERVAL = """# format: "emg2vsa stiffness schedule"
# version: 1
# specimen: "S1"
# condition: "modular"
# last_step_short: true
# ramp: {"speed_mm_per_s": 5.0, "gear_mm_per_degree": 0.2, "speed_deg_per_s": 25.0, "travel_mm": 15.0, \
"duration_s": 3.0}
# limits: {"stiffness_percent": [20.0, 80.0], "max_preset_ticks": 3000, "actuator": "qbmove-advanced", \
"scale": "preset"}
# provenance: {"study": "palpation"}
# sha256: "7dc3ed258c4fd03cb2c5afc4b64c57e805510b7808fd032bdc5fe119a80bcdb7"
force_from_n,force_to_n,activity_v,stiffness_percent,preset_ticks,stiffness_nm_per_rad
0.5,4.5,5.757460937886603e-05,20.0,600,0.050114447925143815
4.5,7.0,7.682418206315169e-05,80.0,2400,0.9574412513125578
"""
"""A file of a version that knew no intervals."""


def test_files_without_an_interval_are_read_as_they_were_written(tmp_path: Path) -> None:
    path = tmp_path / "s.csv"
    path.write_text(WITHOUT_INTERVAL)
    schedule = read_csv(path)
    assert schedule.interval_percent is None
    assert schedule.exported.tolist() == [600, 2400]
    write_csv(path, schedule)
    assert path.read_text() == WITHOUT_INTERVAL
    write_json(tmp_path / "s.json", schedule)
    assert json.loads((tmp_path / "s.json").read_text())["version"] == 1
    assert_same(read_json(tmp_path / "s.json"), schedule)


def test_csv_is_a_plain_table_to_others(tmp_path: Path) -> None:
    schedule = schedule_of()
    write_csv(tmp_path / "s.csv", schedule)
    table = pd.read_csv(tmp_path / "s.csv", comment="#")
    np.testing.assert_allclose(table["stiffness_percent"], schedule.stiffness_percent, rtol=1e-15)
    np.testing.assert_array_equal(table["force_to_n"], schedule.step_force_n[1:])


def test_windows_line_ends_are_read(tmp_path: Path) -> None:
    path = tmp_path / "s.csv"
    write_csv(path, schedule_of())
    path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    assert_same(read_csv(path), schedule_of())


def test_write_schedule_names_files_after_specimen_and_condition(tmp_path: Path) -> None:
    paths = write_schedule(tmp_path / "new", schedule_of())
    assert [path.name for path in paths] == ["S1_modular.csv", "S1_modular.json"]
    assert_same(read_csv(paths[0]), read_json(paths[1]))


@pytest.mark.parametrize("name", ["a/b", "..", "a\\b", "a:b"])
def test_names_that_are_no_file_names(name: str, tmp_path: Path) -> None:
    with pytest.raises(ScheduleError, match="part of a file name"):
        write_schedule(tmp_path, dataclasses.replace(schedule_of(), specimen=name))
    assert list(tmp_path.iterdir()) == []


@BOTH
def test_a_bad_schedule_is_not_written(write: Write, read: Read, name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    write(path, schedule_of())
    before = path.read_bytes()
    schedule = schedule_of()
    with pytest.raises(ScheduleError, match="row 1, column preset_ticks"):
        write(path, dataclasses.replace(schedule, preset=schedule.preset + 5000 / 3000))
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def document(tmp_path: Path) -> dict[str, Any]:
    write_json(tmp_path / "s.json", schedule_of())
    content: dict[str, Any] = json.loads((tmp_path / "s.json").read_text())
    return content


def put(content: dict[str, Any], place: tuple[Any, ...], value: Any) -> None:
    for key in place[:-1]:
        content = content[key]
    content[place[-1]] = value


@pytest.mark.parametrize(
    ("place", "value", "complaint"),
    [
        (("steps", 4, "preset_ticks"), 4000, "row 5, column preset_ticks: expected 0 to 3000"),
        (("steps", 4, "preset_ticks"), 1.5, "row 5, column preset_ticks: expected a whole number, but found 1.5"),
        (("steps", 4, "preset_ticks"), True, "row 5, column preset_ticks: expected a whole number, but found True"),
        (("steps", 4, "preset_ticks"), 10**30, "row 5, column preset_ticks: expected a whole number"),
        (("steps", 0, "activity_v"), "high", "row 1, column activity_v: expected a number, but found 'high'"),
        (("steps", 0, "activity_v"), None, "row 1, column activity_v: expected a number, but found None"),
        (("steps", 0, "activity_v"), float("nan"), "row 1, column activity_v: expected a finite number"),
        (("steps", 0, "stiffness_percent"), 19.0, "row 1, column stiffness_percent: expected 20 to 80 %"),
        (("steps", 9, "force_from_n"), 3.0, "row 10, column force_from_n: expected 3.2, where the step before ends"),
        (("steps", 9), {}, "row 10: expected the columns"),
        (("steps", 9), 7, "row 10: expected the columns .*, but found 7"),
        (("steps",), [], "at least one force step"),
        (("steps",), {}, "steps: expected a list"),
        (
            ("steps", 4, "stiffness_low_percent"),
            79.0,
            "row 5, column stiffness_low_percent: expected 20 % to stiffness",
        ),
        (
            ("steps", 4, "stiffness_low_percent"),
            10.0,
            "row 5, column stiffness_low_percent: expected 20 % to stiffness",
        ),
        (
            ("steps", 4, "stiffness_high_percent"),
            81.0,
            "row 5, column stiffness_high_percent: expected stiffness_percent",
        ),
        (
            ("steps", 4, "stiffness_high_percent"),
            20.0,
            "row 5, column stiffness_high_percent: expected stiffness_percent",
        ),
        (("steps", 4, "stiffness_high_percent"), float("nan"), "row 5, column stiffness_high_percent"),
        (
            ("steps", 4, "stiffness_high_percent"),
            None,
            "column stiffness_high_percent: expected a number, but found None",
        ),
        (("version",), 3, "format: expected emg2vsa stiffness schedule 1 or 2"),
        (
            ("version",),
            1,
            "row 1: expected the columns force_from_n, force_to_n, activity_v, stiffness_percent, preset",
        ),
        (("ramp", "speed_mm_per_s"), -5.0, "ramp.speed_mm_per_s: expected a positive number"),
        (("ramp", "extra"), 1, "ramp: expected the keys"),
        (("limits", "stiffness_percent"), [20.0], "limits.stiffness_percent: expected two numbers"),
        (("limits", "max_preset_ticks"), 2900, "row 1, column preset_ticks: expected the ticks of its percent, 580"),
        (("limits", "actuator"), "motor", "limits.actuator"),
        (("provenance", "study"), 3, "provenance, study: expected text, but found 3"),
        (("provenance", "study"), "other", "sha256: expected the digest"),
        (("sha256",), "0", "sha256: expected the digest"),
        (("last_step_short",), False, "row 22, column force_to_n: expected a step of 0.3 N"),
        (("more",), 1, "expected the keys"),
    ],
)
def test_planted_corruption(tmp_path: Path, place: tuple[Any, ...], value: Any, complaint: str) -> None:
    content = document(tmp_path)
    put(content, place, value)
    path = tmp_path / "s.json"
    path.write_text(json.dumps(content))
    with pytest.raises(ScheduleError, match=complaint) as caught:
        read_json(path)
    assert caught.value.where.startswith(str(path))
    assert "Export the schedule again" in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("0.5,0.8,", "0.5,0.8,x", "row 1, column activity_v: expected a number, but found 'x"),
        ("0.8,1.1,", "0.8,", "row 2: expected 8 values, but found 7"),
        ("0.8,1.1,", "0.8,1.0,", "row 3, column force_from_n: expected 1.0, where the step before ends"),
        ("0.8,1.1,", "0.8,nan,", "row 3, column force_from_n: expected nan"),
        ("force_from_n,", "from,", "header row: expected force_from_n"),
        ("# version: 2", "# version: 9", "format: expected emg2vsa stiffness schedule 1 or 2"),
        ("# version: 2", "# version: one", "version: expected a JSON value, but found one"),
        ("# version: 2", "# version: 1", "header row: expected force_from_n"),
        ("# version: 2\n", "", "expected the keys"),
        ('"P0', '"P1', ""),
    ],
)
def test_planted_corruption_of_csv(tmp_path: Path, old: str, new: str, complaint: str) -> None:
    path = tmp_path / "s.csv"
    write_csv(path, schedule_of(note="P07"))
    path.write_text(path.read_text().replace(old, new, 1))
    with pytest.raises(ScheduleError, match=complaint or "sha256") as caught:
        read_csv(path)
    assert caught.value.where.startswith(str(path))


@BOTH
@settings(max_examples=150, deadline=None)
@given(data=st.data())
def test_any_changed_byte_is_noticed(write: Write, read: Read, name: str, data: st.DataObject) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, name)
        write(path, schedule_of())
        content = bytearray(path.read_bytes())
        at = data.draw(st.integers(0, len(content) - 1))
        content[at] = data.draw(st.integers(0, 255))
        path.write_bytes(content)
        with suppress(ScheduleError):
            # a change of white space or of a line end is none
            assert_same(read(path), schedule_of())


@BOTH
@pytest.mark.parametrize("content", [b"", b"[]", b"\xff\xfe", b"[" * 100000, b"# x: " + b"[" * 100000])
def test_files_that_are_no_schedules(write: Write, read: Read, name: str, tmp_path: Path, content: bytes) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(ScheduleError):
        read(tmp_path / name)


@BOTH
def test_truncated_files(write: Write, read: Read, name: str, tmp_path: Path) -> None:
    write(tmp_path / name, schedule_of())
    content = (tmp_path / name).read_bytes()
    for length in range(0, len(content) - 2, 97):
        (tmp_path / name).write_bytes(content[:length])
        with pytest.raises(ScheduleError):
            read(tmp_path / name)


@BOTH
def test_absent_file(write: Write, read: Read, name: str, tmp_path: Path) -> None:
    with pytest.raises(ScheduleError, match="No such file"):
        read(tmp_path / name)


def test_a_key_that_stands_twice_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "s.json"
    write_json(path, schedule_of())
    text = path.read_text()
    path.write_text(text.replace('"speed_mm_per_s": 5.0', '"speed_mm_per_s": 500.0, "speed_mm_per_s": 5.0', 1))
    with pytest.raises(
        ScheduleError,
        match=r"s\.json, speed_mm_per_s: expected every key once, but found one key "
        r"twice\.",
    ):
        read_json(path)
