"""``emg2vsa new --ask``: what is asked, what answers do, and that nothing is left where they end."""

from __future__ import annotations

import io
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.folders_apart import press
from emg2vsa.cli import main
from emg2vsa.study_file import load_study

Screen = pytest.CaptureFixture[str]


def folder_of(
    folder: Path, head: str = "time (s),A1,A2,Fx (N),Fz (N)", factor: float = 1.0, timed: bool = True
) -> Path:
    """Two people on two objects; EMG in mV, a sideways and a pressing force that goes down."""
    for i, person in enumerate(("ama", "bob")):
        for j, specimen in enumerate(("hard", "soft")):
            emg, force_n = press(i, j, 1000.0, presses=1)
            time = [np.arange(force_n.size) / 1000] if timed else []
            columns = [*time, *(1e3 * emg), 0.05 * force_n, -force_n * factor]
            name = folder / f"{person}_{specimen}.csv"
            np.savetxt(name, np.column_stack(columns), "%.7g", ",", header=head, comments="")
    return folder


def new(folder: Path, monkeypatch: pytest.MonkeyPatch, *answers: str, words: tuple[str, ...] = ()) -> int:
    monkeypatch.setattr("sys.stdin", io.StringIO("".join(f"{line}\n" for line in answers)))
    return main(["new", str(folder), "--ask", *words])


def test_enter_takes_every_guess(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Screen) -> None:
    assert new(folder_of(tmp_path), monkeypatch, *[""] * 8) == 0
    asked = capsys.readouterr().err
    for part in (
        "{participant}_{specimen}.csv", "who pressed: ama, bob", "2 Fz: looks like the force", "(Enter: Fz)",
        "1 A1: looks like EMG, by its spectrum", "by the largest value, 0.", "(Enter: mV)", "(Enter: lowers)",
        "Stiffness of hard",
    ):  # fmt: skip
        assert part in asked
    study = load_study(tmp_path / "study.toml")
    channels = study.recordings[0].channels
    assert {role: (c.name, c.unit) for role, c in channels.emg.items()} == {"A1": ("A1", "mV"), "A2": ("A2", "mV")}
    assert (channels.force.name, channels.force.sign, study.stiffness_n_per_mm) == ("Fz", -1, {})


def test_answers_replace_the_guesses(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    answers = ("ama", "1", "A2=FDS 1=EDC", "uV", "raises", "6,5", "1.5", "3")
    assert new(folder_of(tmp_path), monkeypatch, *answers) == 0
    study = load_study(tmp_path / "study.toml")
    assert (study.participants, study.stiffness_n_per_mm) == (("hard", "soft"), {"ama": 6.5, "bob": 1.5})
    entry = study.recordings[0]
    assert {role: (c.name, c.unit) for role, c in entry.channels.emg.items()} == {
        "FDS": ("A2", "uV"), "EDC": ("A1", "uV"),
    }  # fmt: skip
    assert (entry.channels.force.name, entry.channels.force.sign) == ("Fx", 1)
    assert entry.window.expected_trials == 3
    assert "FILL IN" not in (tmp_path / "study.toml").read_text().partition("\n")[2]


def test_units_and_rates_that_no_file_states(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder_of(tmp_path, "EDC (mV),FDS (mV),Fx (counts),Fz (counts)", 50.0, timed=False)
    assert new(tmp_path, monkeypatch, "", "Fz", "0.02", "", "6", "1.5", "", words=("--fs", "1000")) == 0
    force = load_study(tmp_path / "study.toml").recordings[0].channels.force
    assert (force.name, force.newtons_per_unit, force.fs_hz, force.sign) == ("Fz", 0.02, 1000.0, -1)


def test_a_wrong_answer_gets_one_sentence_and_another_try(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Screen
) -> None:
    typed = "carl|yes|3|Fy||1|3=FDS|1=FDS 2=FDS|1=FDS A1=EDC||volts||sideways||-6|six|inf|||ten|0|"
    answers = typed.split("|")
    assert new(folder_of(tmp_path), monkeypatch, *answers) == 0
    told = [line for line in capsys.readouterr().err.splitlines() if "Expected" in line]
    assert told == [
        "> Expected yes, or a part of the files' names, but found 'carl'.",
        "> Expected a number from 1 to 2, or a name, but found '3'.",
        "> Expected a number from 1 to 2, or a name, but found 'Fy'.",
        *(
            f"> Expected pairs such as 1=FDS 2=EDC, but found {text!r}."
            for text in ("1", "3=FDS", "1=FDS 2=FDS", "1=FDS A1=EDC")
        ),
        "> Expected V, mV or uV, but found 'volts'.",
        "> Expected raises or lowers, but found 'sideways'.",
        *(f"> Expected a number above 0, such as 7.63, but found {text!r}." for text in ("-6", "six", "inf")),
        *(f"> Expected a whole number above 0, such as 10, but found {text!r}." for text in ("ten", "0")),
    ]


@pytest.mark.parametrize("answers", [(), ("", ""), ("", "", "", "", "six")])
def test_the_end_of_the_input_leaves_nothing(
    answers: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Screen
) -> None:
    before = set(folder_of(tmp_path).iterdir())
    assert new(tmp_path, monkeypatch, *answers) == 2
    end = "--ask: expected an answer to every question, but found the end of the input. Answer on a terminal,"
    assert end in capsys.readouterr().err
    assert set(tmp_path.iterdir()) == before


@pytest.mark.skipif(sys.platform == "win32", reason="the shell there has other signs")
@pytest.mark.parametrize("feed", ["<&-", "< /dev/null", "<<< $'\\xff'"])
def test_no_input_and_no_text_are_told(feed: str, tmp_path: Path) -> None:
    command = f"{sys.executable} -m emg2vsa.cli new {folder_of(tmp_path)} --ask {feed}"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "expected an answer to every question, but found the end of the input" in done.stderr
    assert ("Expected yes, or a part of the files' names, but found" in done.stderr) == ("xff" in feed)
    assert not (tmp_path / "study.toml").exists()


def test_a_study_file_is_no_page(tmp_path: Path, capsys: Screen) -> None:
    before = set(folder_of(tmp_path).iterdir())
    for name in (str(tmp_path / "a.html"), str(tmp_path / "a"), ".", "", "/"):
        assert main(["new", str(tmp_path), "--out", name]) == 2
        assert f"--out: expected a name that ends in .toml, but found {str(Path(name))!r}" in capsys.readouterr().err
    assert set(tmp_path.iterdir()) == before


def test_ctrl_c_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Screen) -> None:
    class Keyboard(io.StringIO):
        def readline(self, size: int = -1, /) -> str:
            raise KeyboardInterrupt

    before = set(folder_of(tmp_path).iterdir())
    monkeypatch.setattr("sys.stdin", Keyboard())
    assert main(["new", str(tmp_path), "--ask"]) == 130
    assert "Stopped. Nothing was written." in capsys.readouterr().err
    assert set(tmp_path.iterdir()) == before


def test_asking_and_not_asking_is_refused(tmp_path: Path, capsys: Screen) -> None:
    with pytest.raises(SystemExit):
        main(["new", str(tmp_path), "--ask", "--no-questions"])
    assert "not allowed with argument --ask" in capsys.readouterr().err


def test_the_page_shows_one_recording_with_its_presses(tmp_path: Path, capsys: Screen) -> None:
    assert main(["new", str(folder_of(tmp_path)), "--no-questions"]) == 0
    assert f"Page of one recording: {tmp_path / 'study.html'}" in capsys.readouterr().out
    page = (tmp_path / "study.html").read_text()
    for part in (
        "ama/hard: 1 press found, of these 1 ok", "channel Fz in N at 1000 Hz, turned round, as pressing lowers it.",
        "A1: channel A1 in mV, a guess at 1000 Hz.", "url(#ok)", "Line ",
    ):  # fmt: skip
        assert part in page


def test_the_page_of_a_draft_that_cannot_be_used_says_why(tmp_path: Path) -> None:
    folder_of(tmp_path, "time (s),A1,A2,X (deg),Y (deg)")
    assert main(["new", str(tmp_path), "--no-questions"]) == 0
    page = (tmp_path / "study.html").read_text()
    assert "No press was looked for." in page
    assert "no channel looks like the force" in page
    assert "A1 over time: looks like EMG" in page


def test_only_a_page_of_an_older_draft_is_replaced(tmp_path: Path, capsys: Screen) -> None:
    assert main(["new", str(folder_of(tmp_path)), "--no-questions"]) == 0
    (tmp_path / "study.toml").unlink()
    assert main(["new", str(tmp_path), "--no-questions"]) == 0
    (tmp_path / "study.toml").unlink()
    (tmp_path / "study.html").write_text("mine")
    assert main(["new", str(tmp_path)]) == 2
    assert "study.html: expected a new file, but found an existing one" in capsys.readouterr().err
    assert (tmp_path / "study.html").read_text() == "mine"
    assert not (tmp_path / "study.toml").exists()
