"""``emg2vsa rig run --virtual``: all runs of the file on the emulated rig, those done before left out."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from benchmarks.rig.logs import read_log
from emg2vsa.lab import virtual_runs
from emg2vsa.rig.record.new_folder import how_ended
from emg2vsa.run_folders.presses import read_presses

Rig = Callable[..., tuple[int, str, str]]
RigFile = Callable[..., Path]


def ends(err: str) -> list[str]:
    """What is said of each run, without the guards that are laxer than usual."""
    return [line for line in err.splitlines() if "rig.guards." not in line]


def test_all_runs_are_done_once(rig: Rig, rig_file: RigFile, tmp_path: Path) -> None:
    path, runs = rig_file(), tmp_path / "elsewhere"
    options = ("--virtual", "--out", runs, "--repetitions", 1, "--specimen", "S3")
    status, out, err = rig("run", path, *options, "--condition", "modular", "--jobs", 2)
    assert status == 0, err
    names = ["S3_0_modular", "S3_30_modular"]
    assert sorted(folder.name for folder in runs.iterdir()) == names
    assert [how_ended(runs / name) for name in names] == ["completed"] * 2
    assert sorted(line.split()[1] for line in err.splitlines()) == [f"{name}:" for name in names]
    assert err.splitlines()[1].startswith("2/2 ")
    assert out.startswith("guard: rig.guards.force_n = 50 protects less than 10, the default\n")
    table = [line for line in out.splitlines() if not line.startswith("guard: ")]
    assert table[:3] == [
        "presses done                         S3",
        "modular, 0 degrees                    1",
        "modular, 30 degrees                   1",
    ]
    assert table[3].startswith("runs done: 2, ")
    logs = [(runs / name / "log.csv").read_bytes() for name in names]

    status, out, err = rig("run", path, *options, "--jobs", 1)
    assert status == 0
    assert len(ends(err)) == 1
    assert ends(err)[0].startswith("3/3 S3_0_high-stiffness: completed: 1 of 1 presses, ")
    assert [line for line in out.splitlines() if not line.startswith("guard: ")][1:4] == [
        "high-stiffness, 0 degrees             1",
        "modular, 0 degrees          done before",
        "modular, 30 degrees         done before",
    ]
    assert [(runs / name / "log.csv").read_bytes() for name in names] == logs
    assert read_log(runs / "S3_0_high-stiffness" / "log.csv")[-1].preset == 0


def test_every_mounting_has_a_folder_of_its_own(rig: Rig, rig_file: RigFile, tmp_path: Path) -> None:
    path, runs = rig_file(("repetitions = 2", "repetitions = 1\nmountings = 2")), tmp_path / "runs-virtual"
    options = ("--virtual", "--specimen", "S3", "--angle", 0, "--condition", "high-stiffness")
    status, out, err = rig("run", path, *options)
    assert status == 0, err
    names = ["S3_0_high-stiffness", "S3_0_high-stiffness_mounting-2"]
    assert sorted(folder.name for folder in runs.iterdir()) == names
    assert ("high-stiffness, 0 degrees (2)", "1") in [tuple(row.rsplit(maxsplit=1)) for row in out.splitlines()]
    assert [press.mounting for press in read_presses([runs / name for name in names])] == [1, 2]
    status, _, err = rig("run", path, *options, "--mounting", 3)
    assert (status, "mounting: expected 1, 2, but found 3" in err) == (2, True)


def test_a_run_that_ends_early_is_told_and_done_again(rig: Rig, rig_file: RigFile, tmp_path: Path) -> None:
    options = ("--virtual", "--specimen", "S1", "--angle", 0, "--condition", "high-stiffness", "--repetitions", 1)
    far = rig_file(("gap_mm = 2", "gap_mm = 14.8"))
    far.write_text(far.read_text().replace("force_n = 50", "force_n = 50\ncontact_mm = 20"))
    status, out, err = rig("run", far, *options)
    assert status == 1
    assert "1/1 S1_0_high-stiffness: guard: travel in approach of press 1 (" in err
    assert "high-stiffness, 0 degrees     0, travel\n" in out
    assert rig("run", rig_file(), *options)[0] == 0
    assert how_ended(tmp_path / "runs-virtual" / "S1_0_high-stiffness-2") == "completed"


def test_measured_runs_are_none_of_its_own(rig: Rig, rig_file: RigFile, tmp_path: Path) -> None:
    options = ("--specimen", "S1", "--angle", 0, "--condition", "high-stiffness", "--repetitions", 1)
    measured = tmp_path / "runs" / "S1_0_high-stiffness"
    measured.mkdir(parents=True)
    (measured / "ended.json").write_text('{"how": "completed", "repetitions_done": 2}')
    assert rig("run", rig_file(), "--virtual", *options)[0] == 0
    assert [path.name for path in (tmp_path / "runs").iterdir()] == [measured.name]
    assert rig("run", rig_file(), "--virtual", "--out", tmp_path / "runs", *options)[0] == 0
    assert sorted(path.name for path in (tmp_path / "runs").iterdir()) == [measured.name, f"{measured.name}-2"]


@pytest.mark.parametrize("how", ["interrupted", "full"])
def test_what_stops_one_run(how: str, rig: Rig, rig_file: RigFile, monkeypatch: pytest.MonkeyPatch) -> None:
    ran: list[Path] = []

    def run_virtual(plan: Any, rig: Any, emulated: Any, folder: Path, **other: Any) -> virtual_runs.Ended:
        ran.append(folder)
        if how == "full":
            raise virtual_runs.SettingError(folder, wanted="room", found="none", do="Free some.")
        return virtual_runs.Ended("interrupted", "Ctrl-C", "", "load", 1, 1.0, "")

    monkeypatch.setattr(virtual_runs, "run_virtual", run_virtual)
    status, out, err = rig("run", rig_file(), "--virtual", "--specimen", "S1", "--jobs", 1)
    if how == "interrupted":
        assert (status, len(ran)) == (130, 1)
    else:
        assert (status, len(ran)) == (1, 3)
        assert "not run. " in err
        assert out.count("not run") == 3
