"""A reader of another package: through the command line and a study; its faults; and what keys say of it."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from emg2vsa.cli import main
from emg2vsa.errors import RecordingError
from emg2vsa.pipeline.plan import survey
from emg2vsa.readers.front_door import open_recording, read
from emg2vsa.settings import SimulationSettings
from emg2vsa.study_file import load_study
from emg2vsa.worlds.people.recording import RecordingStream
from tests.small import study_of_files

Install = Callable[..., Path]

ARGUMENTS = "--emg", "EDC", "--emg", "FDS", "--force", "Fz", "--json"


@pytest.fixture(scope="module")
def text() -> str:
    """Three presses in the format of the example package."""
    settings = SimulationSettings(repetitions=3)
    made = RecordingStream(np.random.SeedSequence(4), settings, a_v=2e-5, b_v=8e-6, window_n=(0.5, 7.0)).whole()
    muscles = list(made.emg_v)[:2]
    rows = np.column_stack([*(made.emg_v[name] * 1e6 for name in muscles), made.force_n])
    lines = [f"LAB {made.fs_hz:g}", "EDC FDS Fz", "uV uV N", *(" ".join(f"{x:.6g}" for x in row) for row in rows)]
    return "\n".join(lines) + "\n"


@pytest.fixture
def recording(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "press.lab"
    path.write_text(text)
    return path


def test_a_file_of_its_format_is_fitted(install: Install, recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fit", str(recording), *ARGUMENTS]) != 0
    capsys.readouterr()
    install()
    assert main(["fit", str(recording), *ARGUMENTS]) == 0
    told = json.loads(capsys.readouterr().out)
    assert len(told["trials"]) == 3
    assert all(4e-6 < trial["b_v"] < 16e-6 for trial in told["trials"])
    assert "read by the reader lab of lab-tools 1.0" in told["notes"]
    assert main(["inspect", str(recording)]) == 0
    assert "lab text" in capsys.readouterr().out


def test_our_own_readers_come_first_where_content_tells(install: Install, tmp_path: Path) -> None:
    install(
        code="class LabText:\n    name = 'all'\n    sniff = lambda path, head: True\n    open_recording = None.__eq__"
    )
    path = tmp_path / "x.tdms"
    path.write_bytes(b"TDSm" + bytes(60))
    with pytest.raises(RecordingError, match=r"TDMS|npTDMS"):
        open_recording(path)


BODY = "class LabText:\n    name = 'lab text'\n    sniff = staticmethod(lambda path, head: head.startswith(b'LAB '))\n"
CONTENTS = "from types import SimpleNamespace as S\nfrom emg2vsa.readers.opened import Contents\n"
BROKEN = {
    "import no_such_module_at_all": "expected a module that can be imported, but found ModuleNotFoundError",
    "raise SystemExit": "expected a module that can be imported, but found SystemExit",
    "LabText = 1": r"a reader with name \(text\), sniff\(path, head\), open_recording\(path\), but found no name",
    "class LabText:\n    name = 'x'\n    sniff = 1": "but found no sniff",
    "class LabText:\n    name = 'x'\n    sniff = len\n    open_recording = len": "sniff to say whether .* TypeError",
}
"""Code of a plugin that cannot even be asked, and what is said of it."""


@pytest.mark.parametrize("code", BROKEN)
def test_a_reader_that_cannot_be_asked_is_named_and_stops_no_other_file(
    install: Install, tmp_path: Path, code: str
) -> None:
    install(code=code)
    unknown = tmp_path / "unknown.bin"
    unknown.write_bytes(b"\x07\x00LAB")
    with pytest.raises(RecordingError, match=f"unknown format; plugin lab of lab-tools 1.0: .*{BROKEN[code]}"):
        open_recording(unknown)
    csv = tmp_path / "x.csv"
    csv.write_text("time (s),EMG (V)\n" + "".join(f"{i / 1000},{i % 7}\n" for i in range(50)))
    found = read(csv, ["EMG"])
    assert found.channels[0].samples.size == 50
    assert any("lab of lab-tools 1.0: expected" in note for note in found.notes)


OPENED = {
    "        raise KeyError('row 3')": r"lab of lab-tools 1.0 can read, but found that it failed \(KeyError: 'row 3'\)",
    "        return None": "it failed .AttributeError",
    "        return S(contents=Contents((1,)))": "contents is no Contents with names",
    "        return S(contents=Contents(('a',)), describe=lambda: [1])": "describe gave no ChannelInfo",
    "        return S(contents=Contents(('a',)), load=lambda indices: [[1.0]])": "load gave no StoredChannel",
}
"""What open_recording does, and what is said of it."""


@pytest.mark.parametrize("body", OPENED)
def test_a_reader_that_fails_is_one_error(install: Install, recording: Path, body: str) -> None:
    install(code=f"{CONTENTS}{BODY}    @staticmethod\n    def open_recording(path):\n{body}\n")
    with pytest.raises(RecordingError, match=OPENED[body]):
        use(recording)


def use(path: Path) -> None:
    """Ask for everything that an opened recording offers."""
    _, opened = open_recording(path)
    if hasattr(opened.opened, "describe"):  # type: ignore[attr-defined]
        opened.describe()
    opened.load([0])


def test_the_command_says_one_line(install: Install, recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    install(code=f"{BODY}    open_recording = staticmethod(lambda path: 1 / 0)\n")
    assert main(["fit", str(recording), *ARGUMENTS]) == 2
    said = capsys.readouterr().err
    assert "Traceback" not in said
    assert said.count("\n") == 1
    assert "tell the authors of lab-tools, or uninstall it" in said


STUDY = study_of_files("{participant}_{specimen}.lab", emg='[channels.emg]\nEDC.name = "EDC"\nFDS.name = "FDS"\n')


def test_another_version_makes_trials_stale(install: Install, tmp_path: Path, text: str) -> None:
    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    (tmp_path / "P01_S1.lab").write_text(text)

    def trials() -> tuple[str, tuple[str, ...]]:
        step = survey(load_study(path), ("trials",), pytest.fail).steps["trials/P01/S1"]
        return step.status, step.reasons

    install()
    assert main(["run", str(path), "--only", "trials", "--jobs", "1", "-q"]) == 0
    assert trials() == ("fresh", ())
    install(version="1.1")
    status, reasons = trials()
    assert status == "stale"
    assert any("lab-tools" in reason for reason in reasons)
    install()
    assert trials() == ("fresh", ())


def test_packages_without_readers_change_no_key(install: Install, tmp_path: Path, text: str) -> None:
    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    (tmp_path / "P01_S1.lab").write_text(text)

    def status() -> str:
        return survey(load_study(path), ("trials",), pytest.fail).steps["trials/P01/S1"].status

    install(entries={})
    main(["run", str(path), "--only", "trials", "--jobs", "1", "-q"])
    assert status() == "failed"
    install(entries={"emg2vsa.statistics": {"alexander-govern": "lab_tools:alexander_govern"}})
    assert status() == "failed"
    install()
    assert status() == "stale"
