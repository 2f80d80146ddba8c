"""What a stranger types, and what the program answers.

What ``emg2vsa report`` says of a report that is up to date.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from emg2vsa.cli import main


def test_power_reproduces_the_sample_size(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tools", "power", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["power"] == pytest.approx(0.819421399316, abs=1e-12)
    assert said["participants_needed"] == 14


def test_check_judges_a_session(study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(study), "P01", "--jobs", "1"]) == 0
    assert capsys.readouterr().out.startswith(("P01    GOOD", "P01    USABLE"))
    next(study.parent.glob("data/sub-P01/emg/*acq-S3_emg.bdf")).unlink()
    assert main(["check", str(study), "P01", "--jobs", "1"]) == 1
    said = capsys.readouterr().out
    assert said.startswith("P01    UNREADABLE")
    assert "S3: cannot be used: " in said
    assert "No such file" in said


def test_simulate_never_overwrites(study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tools", "simulate", str(study)]) == 2
    assert "--overwrite" in capsys.readouterr().err


def test_fit_lists_channels_then_fits(study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(next(study.parent.glob("data/sub-P01/emg/*acq-S1_emg.bdf")))
    assert main(["fit", path]) == 0
    assert "Fz" in capsys.readouterr().out
    assert main(["fit", path, "--emg", "EDC", "--emg", "FDS", "--force", "Fz", "--sign", "-1", "--json"]) == 0
    trials = json.loads(capsys.readouterr().out)["trials"]
    assert len(trials) == 4
    assert all(row["b_lo_v"] < row["b_v"] < row["b_hi_v"] for row in trials)
    assert sum(row["b_v"] for row in trials) / 4 == pytest.approx(20e-6, rel=0.15)


@pytest.mark.parametrize("specimen", ["S1", "S3", "S5"])
def test_fit_notices_a_wrong_sign(study: Path, specimen: str, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(next(study.parent.glob(f"data/sub-P01/emg/*acq-{specimen}_emg.bdf")))
    main(["fit", path, "--emg", "EDC", "--emg", "FDS", "--force", "Fz", "--json"])
    said = json.loads(capsys.readouterr().out)
    assert any(note.endswith("is its sign -1?") for note in said["notes"])
    assert all(row["verdict"] == "rejected" for row in said["trials"])


def test_fit_says_which_channel_is_not_there(study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(next(study.parent.glob("data/sub-P01/emg/*acq-S1_emg.bdf")))
    assert main(["fit", path, "--emg", "EDX", "--force", "Fz"]) == 2
    assert "Did you mean 'EDC'?" in capsys.readouterr().err


def test_fit_lists_every_bad_option(study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(next(study.parent.glob("data/sub-P01/emg/*acq-S1_emg.bdf")))
    arguments = ["--emg", "EDC", "--force", "Fz", "--bin", "-1", "--min-duration", "0"]
    assert main(["fit", path, *arguments]) == 2
    said = capsys.readouterr().err
    assert "bin_n" in said
    assert "min_duration_s" in said


def test_schedules_are_exported_and_read_back(study: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from emg2vsa.schedule_files import read_csv, read_json

    out = tmp_path / "out"
    assert main(["schedule", str(study), "--out", str(out), "--condition", "modular", "--json", "--jobs", "1"]) == 0
    files = [Path(name) for name in json.loads(capsys.readouterr().out)["files"]]
    assert {path.stem for path in files} == {"S1_modular", "S3_modular", "S5_modular", "S_new_modular"}
    for path in files:
        schedule = (read_csv if path.suffix == ".csv" else read_json)(path)
        assert 20 <= schedule.stiffness_percent.min() <= schedule.stiffness_percent.max() <= 80


def test_the_page_and_the_folders_are_told(ran: Path, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert main(["report", str(ran), "--jobs", "1"]) == 0
    page, *folders = capsys.readouterr().out.splitlines()
    reports = ran.parents[2] / "reports" / "small"
    assert page == str(reports / "index.html")
    assert f"{reports / 'participants'}: 2 files" in folders
    assert main(["report", str(ran), "--jobs", "1", "--json"]) == 0
    files = json.loads(capsys.readouterr().out)["files"]
    assert sum(int(line.rpartition(": ")[2].split()[0]) for line in folders) == len(files)
