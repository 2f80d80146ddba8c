"""What ``emg2vsa new`` leaves in a folder: a study file with its page or neither, and every other file as it was."""

from __future__ import annotations

import io
import os
import shlex
import signal
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.folders_apart import press
from emg2vsa.cli import main
from emg2vsa.study_file import load_study

Screen = pytest.CaptureFixture[str]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """One person on two objects, in a folder whose name a shell would cut."""
    folder = tmp_path / "B & P"
    folder.mkdir()
    for j, specimen in enumerate(("hard", "soft")):
        emg, force_n = press(0, j, 1000.0, presses=1)
        columns = [np.arange(force_n.size) / 1000, *(1e3 * emg), force_n]
        head = "time (s),EDC (mV),FDS (mV),Fz (N)"
        np.savetxt(folder / f"P1_{specimen}.csv", np.column_stack(columns), "%.7g", ",", header=head, comments="")
    return folder


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


@pytest.mark.parametrize("name", ["study.toml", "study.html"])
def test_a_file_that_appears_during_the_questions_is_kept(
    name: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: Screen
) -> None:
    class Meanwhile(io.StringIO):
        def readline(self, size: int = -1, /) -> str:
            (folder / name).write_text("mine")
            return "\n"

    before = names(folder)
    monkeypatch.setattr("sys.stdin", Meanwhile())
    assert main(["new", str(folder), "--ask"]) == 2
    assert f"{name}: expected a new file, but found an existing one" in capsys.readouterr().err
    assert (folder / name).read_text() == "mine"
    assert names(folder) == before | {name}


@pytest.mark.parametrize("call", ["casr.atomic.write_new", "emg2vsa.report.draft_page.draft_page"])
def test_ctrl_c_before_both_files_are_there_leaves_none(
    call: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: Screen
) -> None:
    def stopped(*_: object) -> None:
        raise KeyboardInterrupt

    before = names(folder)
    with monkeypatch.context() as patched:
        patched.setattr(call, stopped)
        assert main(["new", str(folder), "--no-questions"]) == 130
    assert "Stopped. Nothing was written." in capsys.readouterr().err
    assert names(folder) == before
    assert main(["new", str(folder), "--no-questions"]) == 0
    assert names(folder) == before | {"study.toml", "study.html"}


def test_ctrl_c_waits_until_both_files_are_there(folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: Screen) -> None:
    link = os.link

    def stopped(*paths: Path) -> None:
        link(*paths)
        signal.raise_signal(signal.SIGINT)

    before = names(folder)
    monkeypatch.setattr("os.link", stopped)
    assert main(["new", str(folder), "--no-questions"]) == 130
    assert "Stopped. The study file and its page are written." in capsys.readouterr().err
    assert names(folder) == before | {"study.toml", "study.html"}


@pytest.mark.skipif(sys.platform in ("win32", "darwin"), reason="names of files are text there")
def test_names_that_are_no_text_are_left_out(folder: Path, capsys: Screen) -> None:
    odd = os.fsencode(folder) + b"/P1_m\xfcll.csv"
    Path(os.fsdecode(odd)).write_bytes((folder / "P1_hard.csv").read_bytes())
    Path(os.fsdecode(os.fsencode(folder) + b"/Notiz-M\xfcller.txt")).write_text("tired\n")
    assert main(["new", str(folder), "--no-questions"]) == 0
    told = capsys.readouterr().out
    assert r"not read: P1_m\xfcll.csv, a path that is not in UTF-8: rename it" in told
    files = [entry.emg_file.name for entry in load_study(folder / "study.toml").recordings]
    assert files == ["P1_hard.csv", "P1_soft.csv"]
    whole = Path(os.fsdecode(os.fsencode(folder) + b"\xfc"))
    whole.mkdir()
    assert main(["new", str(whole)]) == 2
    assert r"P\xfc: expected a path in UTF-8" in capsys.readouterr().err


def test_the_next_command_can_be_copied(folder: Path, capsys: Screen) -> None:
    assert main(["new", str(folder), "--no-questions"]) == 0
    (line,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("Then: ")]
    assert shlex.split(line) == ["Then:", "emg2vsa", "check", str(folder / "study.toml")]


def test_a_rate_that_the_files_state_is_left_aside(folder: Path, capsys: Screen) -> None:
    assert main(["new", str(folder), "--no-questions", "--fs", "500"]) == 0
    assert "--fs 500: left aside, as the files state their rates" in capsys.readouterr().out
    assert load_study(folder / "study.toml").recordings[0].channels.force.fs_hz is None


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--stiffness", "hard=1", "--stiffness", "hard=2"), "--stiffness: expected each specimen once"),
        (("--name", "a b"), "--name: expected letters, digits"),
        (("--name", ""), "--name: expected letters, digits"),
    ],
)
def test_options_that_the_study_file_would_refuse(
    words: tuple[str, ...], said: str, folder: Path, capsys: Screen
) -> None:
    before = names(folder)
    assert main(["new", str(folder), "--no-questions", *words]) == 2
    assert said in capsys.readouterr().err
    assert names(folder) == before


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("values", ["huge", "infinite"])
def test_values_beyond_every_instrument_are_said(values: str, folder: Path, capsys: Screen) -> None:
    for path in folder.iterdir():
        table = np.loadtxt(path, delimiter=",", skiprows=1)
        if values == "huge":
            table[:, 1:] *= 1e300, 1e-300, 1e200
        else:
            table[100, 1:3], table[200, 1:3] = np.inf, -np.inf
        head = "time (s),EDC (mV),FDS (mV),Fz (N)"
        np.savetxt(path, table, "%.7g", ",", header=head, comments="")
    assert main(["new", str(folder), "--no-questions"]) == 0
    page = (folder / "study.html").read_text()
    assert "nan to nan" not in page
    assert "no signal: values up to" in page if values == "huge" else "EDC: looks like EMG" in capsys.readouterr().out


def test_answers_as_people_type_them(folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: Screen) -> None:
    for path in folder.iterdir():
        table = np.loadtxt(path, delimiter=",", skiprows=1)
        for person in ("ama", "bob"):
            name = folder / f"{person}_{path.stem.split('_')[1]}.csv"
            np.savetxt(name, table, "%.7g", ",", header="time (s),EDC,FDS,Fz (kg)", comments="")
        path.unlink()
    monkeypatch.setattr("sys.stdin", io.StringIO("n\nno\nama\n?\nµV\nkg\nraises\n\n\n\n"))
    assert main(["new", str(folder), "--ask"]) == 0
    asked = capsys.readouterr().err
    assert "Then what was pressed?" in asked
    assert asked.count("The unit: V, mV or uV?") == 2
    assert "Wanted: V, mV or uV." in asked
    study = load_study(folder / "study.toml")
    assert study.participants == ("hard", "soft")
    channels = study.recordings[0].channels
    assert (channels.emg["EDC"].unit, channels.force.unit) == ("uV", "kgf")
