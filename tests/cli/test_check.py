"""What ``check`` prints, and which recordings it judges as they land."""

from __future__ import annotations

import io
import itertools
import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from emg2vsa.cli import main
from emg2vsa.pipeline.judged_sessions import landings, told
from emg2vsa.session_verdict import SessionVerdict, SpecimenVerdict
from emg2vsa.study import RecordingEntry
from tests.small import study_of_files


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def verdicts() -> list[SessionVerdict]:
    good = SpecimenVerdict("S1", 8, 8, 8, 0, 0, "", ())
    light, remedy = "reached 5.6 of 7 N", "ask for firmer presses; show the target force"
    slow = SpecimenVerdict("S1", 8, 8, 7, 0, 1, "", (f"press 3 rejected: {light}",), cause=light, remedy=remedy)
    return [SessionVerdict("P1", "good", (good,), good.advice), SessionVerdict("P2", "usable", (slow,), slow.advice)]


def test_one_line_for_a_good_session_the_remedy_beside_each_remark_and_totals() -> None:
    assert list(told(verdicts(), io.StringIO())) == [
        "P1     GOOD        S1 8/8",
        "P2     USABLE      S1 7/8",
        "    S1: press 3 rejected: reached 5.6 of 7 N",
        "      -> ask for firmer presses; show the target force",
        "1 good, 1 usable, 0 to repeat",
    ]


def test_the_law_of_force_has_a_line_of_its_own() -> None:
    good = replace(verdicts()[0], law="The logarithm v = a + b ln F fits.")
    assert list(told([good], io.StringIO())) == [
        "P1     GOOD        S1 8/8",
        "    The logarithm v = a + b ln F fits.",
    ]
    bent = replace(verdicts()[1], advice=(), law="The logarithm v = a + b ln F does not fit.", law_fits=False)
    assert list(told([good, bent], io.StringIO())) == [
        "P1     GOOD        S1 8/8",
        "P2     USABLE      S1 7/8",
        "    The logarithm v = a + b ln F does not fit.",
        "1 good, 1 usable, 0 to repeat",
        "The presses of 1 of 2 people contradict the logarithm v = a + b ln F.",
    ]


def test_colour_on_a_terminal_unless_no_color(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NO_COLOR", raising=False)
    assert "\x1b[1;32mGOOD" in next(told(verdicts(), Terminal()))
    assert "\x1b" not in "".join(told(verdicts(), io.StringIO()))
    monkeypatch.setenv("NO_COLOR", "1")
    assert "\x1b" not in "".join(told(verdicts(), Terminal()))


def test_a_recording_is_told_when_its_files_are_complete(tmp_path: Path) -> None:
    emg, force = tmp_path / "a.csv", tmp_path / "a_force.csv"
    old = tmp_path / "old.csv"
    old.write_text("x")
    entries = [SimpleNamespace(key="P/a", files=(emg, force)), SimpleNamespace(key="P/old", files=(old,))]

    def write(path: Path, text: str, when: int) -> None:
        path.write_text(text)
        os.utime(path, (when, when))

    script = {
        1: lambda: write(emg, "1", 1), 2: lambda: write(emg, "12", 2), 3: lambda: write(force, "", 3),
        6: lambda: write(force, "1", 4), 9: lambda: write(force, "12", 5),
    }  # fmt: skip
    looks = itertools.count(1)
    at: list[int] = []

    def wait(seconds: float) -> None:
        look = next(looks)
        at.append(look)
        if look == 14:
            raise KeyboardInterrupt
        script.get(look, lambda: None)()

    found = []
    landed = landings(lambda: entries, wait)
    while (entry := _next(landed)) is not None:
        found.append((entry.key, at[-1]))
    # not at looks 2 to 5, while the force file is absent or empty; once more after it changed at look 9
    assert found == [("P/a", 7), ("P/a", 10)]


def _next(landed: Iterator[RecordingEntry]) -> RecordingEntry | None:
    try:
        return next(landed)
    except KeyboardInterrupt:
        return None


STUDY = study_of_files("raw/{participant}_{specimen}.csv")


@pytest.mark.parametrize(
    ("pattern", "files"),
    [("*_{participant}_{specimen}.csv", ["1_P01_S1.csv"]),
     ("{participant}_{specimen}_{repetition}.csv", ["P01_S1_1.csv", "P01_S1_2.csv"])],
)  # fmt: skip
def test_files_of_a_pattern_are_seen_as_they_land(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], pattern: str, files: list[str]
) -> None:
    (tmp_path / "study.toml").write_text(STUDY.replace("{participant}_{specimen}.csv", pattern))
    (tmp_path / "raw").mkdir()
    looks = itertools.count()

    def wait(seconds: float) -> None:
        look = next(looks)
        if look == 4 * len(files):
            raise KeyboardInterrupt
        if look % 4 == 0:
            (tmp_path / "raw" / files[look // 4]).write_text("no table")

    monkeypatch.setattr("emg2vsa.pipeline.judged_sessions.time.sleep", wait)
    assert main(["check", str(tmp_path / "study.toml"), "--watch", str(tmp_path / "raw")]) == 1
    said = capsys.readouterr()
    assert said.out.count("UNREADABLE") == len(files)
    assert said.err.endswith("0 good, 0 usable, 0 to repeat, 1 unreadable\n")


def test_a_misnamed_file_is_told_at_the_next_look(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "study.toml").write_text(STUDY)
    (tmp_path / "raw").mkdir()
    looks = itertools.count()

    def wait(seconds: float) -> None:
        look = next(looks)
        assert 2 * seconds < 2  # a word within 2 s
        if look == 0:
            (tmp_path / "raw" / "P01-S1.csv").write_text("no table")
            (tmp_path / "raw" / ".hidden.csv").write_text("no table")
        if look == 3:
            raise KeyboardInterrupt

    monkeypatch.setattr("emg2vsa.pipeline.judged_sessions.time.sleep", wait)
    assert main(["check", str(tmp_path / "study.toml"), "--watch", str(tmp_path / "raw")]) == 0
    said = capsys.readouterr().err
    assert said.count("P01-S1.csv belongs to no recording of the study. Awaited: P01_S1.csv") == 1
    assert "hidden" not in said


def test_a_pattern_without_a_match_is_told_as_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "study.toml").write_text(STUDY.replace("{participant}_", "*_{participant}_"))
    assert main(["check", str(tmp_path / "study.toml")]) == 1
    assert (
        "*_P01_S1.csv: expected a readable file, but found no file that matches this pattern" in capsys.readouterr().out
    )
