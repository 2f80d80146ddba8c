"""``emg2vsa rig run --calibration``: kappa while the finger presses, and presses that end early."""

from __future__ import annotations

import csv
import json
import os
import signal
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import pytest

from benchmarks.kappa import CAMERA, Trial, presses_of
from benchmarks.rig.plans import known_calibration
from casr.dome.library import shipped
from casr.kappa.estimate import fitted, stated_errors
from casr.kappa.family import families
from casr.kappa.known import KnownSensor
from emg2vsa.calibration.online import NO_GAIN, WIDTH_REACHED
from emg2vsa.calibration.online_pins import KnownPins
from emg2vsa.calibration_file import write_calibration
from emg2vsa.devices.clock import FastClock
from emg2vsa.rig.record.new_folder import good_presses
from emg2vsa.rig.record.press_counts import stopped_presses, verdicts
from emg2vsa.run_folders.presses import read_presses

Rig = Callable[..., tuple[int, str, str]]
RigFile = Callable[..., Path]
ELASTIC = ("gap_mm = 2", 'gap_mm = 2\nworld = "elastic"')
ONE = ("--virtual", "--specimen", "S3", "--condition", "high-stiffness", "--jobs", 1)


@pytest.fixture
def slow_rig(rig_file: RigFile) -> Path:
    """Twenty frames a press, and areas by force alone."""
    path = rig_file(ELASTIC)
    path.write_text(path.read_text().replace("ramp_mm_per_s = 8", "ramp_mm_per_s = 3"))
    return path


@pytest.fixture
def known(tmp_path: Path) -> Path:
    return write_calibration(tmp_path / "known.json", known_calibration())


def table(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(path.read_text().splitlines()))


def test_presses_are_judged_and_end_early(rig: Rig, slow_rig: Path, known: Path, tmp_path: Path) -> None:
    assert rig("commission", slow_rig, "--motor", "--reference", 5, "--virtual")[0] == 0  # a witness of short presses
    status, out, err = rig("run", slow_rig, *ONE, "--calibration", known, "--stop-at", "40%")
    assert status == 0, err
    folder = tmp_path / "runs-virtual" / "S3_0_high-stiffness"
    presses = table(folder / "presses.csv")
    assert [press["verdict"] for press in presses] == ["ok", "ok"]
    assert all(float(press["peak_force_n"]) < 4 for press in presses), "a whole press goes to 5 N"
    rows = [row for row in table(folder / "kappa.csv") if row["stop"]]
    assert [int(row["repetition"]) for row in rows] == [1, 2]
    for press, row in zip(presses, rows, strict=True):
        assert row["stop"] in (WIDTH_REACHED, NO_GAIN)
        assert f"N: {row['stop']}, kappa to " in press["stopped"]
    for row in rows:
        assert float(row["half_width"]) <= 0.45
        assert float(row["low_n_per_mm"]) < 3.35 < float(row["high_n_per_mm"])
        assert row["latency_s"] == ""
    about = json.loads((folder / "kappa.json").read_text())
    assert (about["calibration"], about["stop_at"], about["dropped"]) == ("known.json", 0.4, 0)
    assert about["answered"] == about["frames"] == len(table(folder / "kappa.csv"))
    assert "kappa: by known.json (A, B, C, D, E, 30 presses); at best ±" in out
    assert "kappa after press 2: 3." in out
    # they are done, and no whole presses
    assert good_presses(folder) == 2
    assert set(stopped_presses(folder)) == {1, 2}
    assert verdicts(folder)[1] == ("ok", "")
    read = list(read_presses([folder]))
    assert [press.frames for press in read] == [None, None]
    assert "is no whole press: it was stopped at" in read[0].problem
    assert "# stopped: at " in (folder / "press-001" / "force.csv").read_text()


@pytest.fixture(scope="module")
def by_pins(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """By the pins of a simulated dome that the tables hold, seen by the camera of the emulated rig."""
    presses = presses_of(Trial("J", 1.0, 0.05, 0.0, (1.11, 3.35, 7.63), 5.3, seed=3))[:-2]
    labels = fitted(presses, CAMERA, families(shipped()), stated_errors(CAMERA))
    pins = KnownPins(KnownSensor.of(labels), CAMERA, labels.family.digest)
    return write_calibration(tmp_path_factory.mktemp("by-pins") / "pins.json", replace(known_calibration(), pins=pins))


def test_a_calibration_by_pins_is_read_back_and_judges_by_the_pins(
    rig: Rig, rig_file: RigFile, by_pins: Path, tmp_path: Path
) -> None:
    """The emulated dome is another one than that of the calibration: kappa is told, and not held to the number."""
    path = rig_file()
    path.write_text(path.read_text().replace("ramp_mm_per_s = 8", "ramp_mm_per_s = 3"))
    status, out, err = rig("run", path, *ONE, "--repetitions", 1, "--calibration", by_pins)
    assert status == 0, err
    assert "kappa: by pins.json (A, B, C, D, E, 30 presses); at best ±" in out
    rows = table(tmp_path / "runs-virtual" / "S3_0_high-stiffness" / "kappa.csv")
    told = [row for row in rows if row["kappa_n_per_mm"]]
    assert {row["cues"] for row in told} == {"pins and force"}
    assert len(told) > 5
    assert 1.5 < float(told[-1]["kappa_n_per_mm"]) < 7
    assert float(told[-1]["low_n_per_mm"]) < float(told[-1]["kappa_n_per_mm"]) < float(told[-1]["high_n_per_mm"])


def test_another_camera_than_that_of_the_pins_is_refused(
    rig: Rig, rig_file: RigFile, by_pins: Path, tmp_path: Path
) -> None:
    """Before anything moves; the rate of its frames alone makes no other camera."""
    for changed, status in (({"depth_mm": 55.0}, 2), ({"frame_rate_hz": 30.0}, 0)):
        camera = tmp_path / f"{next(iter(changed))}.toml"
        camera.write_text(replace(CAMERA, **changed).to_toml())
        options = ("--repetitions", 1, "--calibration", by_pins, "--camera", camera, "--out", tmp_path / camera.stem)
        found, _, err = rig("run", rig_file(), *ONE, *options)
        assert found == status, err
        assert ("--camera: expected the camera that pins.json was made with, but found another" in err) == bool(status)
        assert (tmp_path / camera.stem).exists() != bool(status)


def test_the_same_run_gives_the_same_rows_and_without_a_width_whole_presses(
    rig: Rig, rig_file: RigFile, known: Path, tmp_path: Path
) -> None:
    files = []
    for name in ("first", "again"):
        options = ("--out", tmp_path / name, "--repetitions", 1, "--calibration", known)
        status, _, err = rig("run", rig_file(ELASTIC), *ONE, *options)
        assert status == 0, err
        folder = tmp_path / name / "S3_0_high-stiffness"
        files.append((folder / "kappa.csv").read_bytes())
        assert table(folder / "presses.csv")[0]["stopped"] == ""
        assert float(table(folder / "presses.csv")[0]["peak_force_n"]) >= 5
    assert files[0] == files[1]
    status, _, err = rig("run", rig_file(ELASTIC), *ONE, "--out", tmp_path / "none", "--repetitions", 1)
    assert status == 0, err
    without = tmp_path / "none" / "S3_0_high-stiffness" / "log.csv"
    assert without.read_bytes() == (tmp_path / "first" / "S3_0_high-stiffness" / "log.csv").read_bytes()


def test_a_width_that_cannot_be_reached_is_said_before_the_first_press(
    rig: Rig, rig_file: RigFile, known: Path
) -> None:
    options = ("--repetitions", 1, "--calibration", known, "--stop-at", 1)
    status, _, err = rig("run", rig_file(ELASTIC), *ONE, *options)
    assert status == 0
    first, note, second = err.splitlines()[:3]
    assert first.startswith("emg2vsa: a width of ±1.0% cannot be reached with this calibration")
    assert note.endswith("known.json reaches to 7 N, and these presses turn back at 5 N: kappa is told up to there.")
    assert second.startswith("1/1 ")


def test_presses_unlike_those_of_the_calibration_are_noted_or_refused(
    rig: Rig, rig_file: RigFile, tmp_path: Path
) -> None:
    measured = write_calibration(tmp_path / "measured.json", known_calibration(simulated=False))
    one = (*ONE, "--repetitions", 1, "--calibration", measured)
    path = rig_file(ELASTIC)
    strong = path.read_text()
    path.write_text(strong.replace("f_max_n = 5", "f_max_n = 0.8"))
    status, _, err = rig("run", path, *one)
    assert (status, "expected presses beyond 1 N, where measured.json begins, but found f_max_n = 0.8" in err) == (
        2,
        True,
    )
    path.write_text(strong.replace("f_max_n = 5", "f_max_n = 2"))
    status, _, err = rig("run", path, *one)
    assert status == 0, err
    assert "emg2vsa: measured.json is by presses of a real rig, and an emulated one presses here" in err
    assert "emg2vsa: measured.json reaches to 7 N, and these presses turn back at 2 N" in err


def test_a_calibration_of_the_emulated_rig_judges_no_real_one(
    rig: Rig, rig_file: RigFile, known: Path, tmp_path: Path
) -> None:
    real = ("--specimen", "S3", "--condition", "high-stiffness")
    status, _, err = rig("run", rig_file(), *real, "--calibration", known)
    assert status == 2
    assert "expected a calibration by presses of a real rig, but found one by presses of an emulated rig" in err
    measured = write_calibration(tmp_path / "measured.json", known_calibration(simulated=False))
    status, _, err = rig("run", rig_file(), *real, "--calibration", measured)
    assert status == 2
    assert f"{tmp_path / 'camera.toml'}: expected the camera file of the tactile camera" in err


SLOWED = 0.25
"A second of the rig takes four: a computer with other work is late by less of the rig's time."
_TRIES = 5
HELD_UP = ("overrun", "stale sensor")
"Guards that end a run where the computer is too busy for the control loop, whoever judges its presses."


@pytest.fixture
def slow_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Run and emulated rig by the same slowed clock."""
    clock = partial(FastClock, SLOWED)
    monkeypatch.setattr("tests.cli.rig.conftest.WallClock", clock)
    monkeypatch.setattr("emg2vsa.lab.real_press.WallClock", clock)


@pytest.mark.realtime
@pytest.mark.parametrize("ended", ["", "killed", "no camera"])
def test_beside_a_run_in_real_time(
    slow_time: None, rig: Rig, served_rigid: SimpleNamespace, known: Path, tmp_path: Path, ended: str
) -> None:
    """A process that is killed ends no press; a camera that is lost ends the run as it does without one."""
    for number in range(1, _TRIES + 1):
        folder = tmp_path / f"try-{number}" / "S3_0_high-stiffness"
        served_rigid.bench.camera.faults.mute = False
        if in_real_time(rig, served_rigid, known, folder, ended):
            return
    raise AssertionError(f"the computer was too busy for the control loop in {_TRIES} runs")


def in_real_time(rig: Rig, served_rigid: SimpleNamespace, known: Path, folder: Path, ended: str) -> bool:
    """Whether the run was carried out; else the computer held up the control loop, and a guard ended it."""

    def break_it() -> None:
        end_s = time.monotonic() + 60
        while not (folder / "press-001" / "frames.tif").exists() and time.monotonic() < end_s:
            time.sleep(0.01)
        if ended == "killed":
            os.kill(estimator_of(os.getpid()), signal.SIGKILL)
        elif ended == "no camera":
            served_rigid.bench.camera.faults.mute = True

    thread = threading.Thread(target=break_it)
    thread.start()
    options = ("--specimen", "S3", "--condition", "high-stiffness", "--repetitions", 1, "--out", folder.parent)
    status, out, err = rig("run", served_rigid.path, *options, "--calibration", known, "--stop-at", 40)
    thread.join()
    end = json.loads((folder / "ended.json").read_text())
    if end["cause"] in HELD_UP:
        return False
    about = json.loads((folder / "kappa.json").read_text())
    press = table(folder / "presses.csv")[0]
    if ended == "no camera":
        assert status == 1
        assert "lost camera" in out
        assert about["trouble"] == ""
        return True
    if end["how"] == "rejected":  # late turns alone; every press was carried out
        assert press["verdict"] == "rejected"
        assert "the computer was busy" in press["why"], press
    else:
        assert status == 0, out + err
    assert "left: probe retracted, motors off" in out
    if ended == "killed":
        assert press["stopped"] == ""
        assert float(press["peak_force_n"]) >= 5
        assert "ended" in about["trouble"]
        assert "frames were left out by the estimator" in err
    else:
        stops = {row["stop"] for row in table(folder / "kappa.csv")} - {""}
        assert len(stops) == 1
        assert f"N: {stops.pop()}, kappa to " in press["stopped"]
        assert about["answered"] + about["dropped"] == about["frames"]
        assert about["latency"]["median_s"] > 0
        assert (folder / "camera.toml").is_file()
    return True


def estimator_of(parent: int) -> int:
    """The child of this process that judges its presses."""
    for each in Path("/proc").glob("[0-9]*/stat"):
        fields = each.read_text().rpartition(")")[2].split()
        if int(fields[1]) == parent and "rig.kappa.judges" in each.with_name("cmdline").read_text():
            return int(each.parent.name)
    raise AssertionError("no estimator")
