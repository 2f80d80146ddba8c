"""``emg2vsa session`` at the command line: what it refuses, and a whole session without a page.

``emg2vsa session emulate``: one clear error for what cannot be emulated, and devices for what can.
"""

from __future__ import annotations

import io
import json
import socket
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.small_study import SIMULATED_SESSION, small_study
from emg2vsa.cli import main
from emg2vsa.session.journal import Judged, line_bytes, read_journal

STUDY = small_study(
    participants=["P03"], specimens=["S1"], muscles=["EDC"], task="press", simulation="muscle_share = { EDC = 1.0 }\n"
)
SESSION = f"[session]\n{SIMULATED_SESSION}repetitions = 1\n"


@pytest.fixture
def study_file(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(STUDY + SESSION, encoding="utf-8")
    return path


def test_a_session_of_one_press_without_a_page(study_file, capsys):
    assert main(["session", str(study_file), "--participant", "P03", "--virtual", "--no-page"]) == 0
    said = capsys.readouterr().out
    assert "completed" in said
    assert "S1 1/1" in said
    assert (study_file.parent / "reports" / "small" / "participants" / "P03.html").exists() or "page:" in said
    assert main(["session", str(study_file), "--participant", "P03", "--virtual", "--no-page"]) == 2
    assert "--resume" in capsys.readouterr().err


def test_a_stopped_session_tells_how_it_goes_on(study_file, capsys, monkeypatch):
    def stop(self, now_s):
        raise KeyboardInterrupt

    monkeypatch.setattr("emg2vsa.worlds.people.pages.EmulatedOperator.turn", stop)
    words = [str(study_file), "--participant", "P03", "--virtual", "--no-page"]
    assert main(["session", *words]) == 1
    first, again, finish = capsys.readouterr().out.splitlines()
    assert first.startswith("ended: Ctrl-C; recorded in ")
    assert again == f"Go on: emg2vsa session {study_file} --participant P03 --resume"
    assert finish == f"Or write the recordings so far: emg2vsa session finish {study_file} --participant P03"
    assert main(["session", *words, "--resume", "--json"]) == 1
    told = capsys.readouterr()
    assert json.loads(told.out)["judged"] is None
    assert "Go on: " in told.err


def test_a_session_in_json_is_one_object_with_its_verdict_and_is_replayed_from_its_folder(study_file, capsys):
    words = [str(study_file), "--participant", "P03"]
    assert main(["session", *words, "--virtual", "--no-page", "--json"]) == 0
    told = capsys.readouterr()
    found = json.loads(told.out)
    assert (found["how"], found["why"]) == ("completed", "")
    assert found["folder"].endswith("sub-P03/press")
    assert found["judged"]["verdicts"]["P03"]["specimens"][0]["ok"] == 1
    assert "completed; recorded in" in told.err
    assert main(["session", "finish", *words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == found["judged"]

    folder = found["folder"]
    words = ["session", "replay", str(study_file), folder]
    assert main(words) == 0
    line, operator, participant, _, press = capsys.readouterr().out.splitlines()
    assert line.endswith(f" of {folder}")
    assert operator == "operator:    The session has ended."
    assert participant == "participant: Finished. Thank you!"
    assert press.split() == ["1", "1", "S1", "ok", "ok", "same"]
    assert main([*words, "--json", "--line", "5"]) == 0
    early = json.loads(capsys.readouterr().out)
    assert (early["line"], early["same"], early["presses"], early["operator"]["ended"]) == (5, True, [], "")
    journal = study_file.parent / folder / "journal.jsonl"
    lines = read_journal(journal)[0]
    judged = next(line for line in lines if isinstance(line.event, Judged))
    other = replace(judged, event=replace(judged.event, verdict="warned"))
    journal.write_bytes(b"".join(line_bytes(other if line is judged else line) for line in lines))
    assert main(words) == 1
    assert "verdict: was warned, is ok" in capsys.readouterr().out
    assert main([*words, "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["presses"][0]["differences"] == ["verdict: was warned, is ok"]


PALPATION = Path(__file__).parents[2] / "studies" / "palpation"
TRIGNO = """
[session]
training_specimens = ["T1"]
emg.kind = "trigno"
emg.command_port = {command}
emg.emg_port = {emg}
emg.channels = {{ EDC = "1", FDS = "5" }}
force.kind = "rig"
force.rig = "rig.toml"
"""


def free_port(kind: int = socket.SOCK_STREAM) -> int:
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@pytest.fixture
def study(tmp_path: Path) -> Path:
    """The palpation study with a Trigno server and the force sensor of a rig."""
    text = (PALPATION / "study.toml").read_text(encoding="utf-8")
    head, _, rest = text.partition("[session]")
    rest = rest.partition("\n\n")[2] if "\n\n" in rest else ""
    tables = TRIGNO.format(command=free_port(), emg=free_port())
    (tmp_path / "study.toml").write_text(head + rest + tables, encoding="utf-8")
    rig = (PALPATION / "rig.toml").read_text(encoding="utf-8")
    ports = f'host = "127.0.0.1"\nhttp_port = {free_port()}\nrdt_port = {free_port(socket.SOCK_DGRAM)}\n'
    (tmp_path / "rig.toml").write_text(rig.replace("[force]\n", f"[force]\n{ports}"), encoding="utf-8")
    return tmp_path / "study.toml"


def emulate(study: Path, *words: str) -> int:
    return main(["session", "emulate", str(study), *words])


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--participant", "P99"), "P99"),
        (("--participant", "P03", "--mistake", "sneezes@3"), "sneezes@3"),
        (("--participant", "P03", "--speed", "0"), "--speed: expected 0.1 to 100"),
        (("--participant", "P03", "--start-delay", "-1"), "--start-delay"),
        (("--participant", "P03", "--truth", "no/such/folder/truth.json"), "no such folder"),
        (("--participant", "P03", "--page", "http://127.0.0.1:9/"), "a page of a running session"),
    ],
)
def test_bad_words_are_named(
    study: Path, words: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert emulate(study, *words) == 2
    assert said in capsys.readouterr().err


def test_a_study_without_devices_is_told_so(capsys: pytest.CaptureFixture[str], study: Path) -> None:
    assert emulate(PALPATION / "study.toml", "--participant", "P03") == 2
    assert "simulated and simulated" in capsys.readouterr().err
    text = study.read_text(encoding="utf-8")
    study.write_text(text[: text.index("\n[session]")], encoding="utf-8")
    assert emulate(study, "--participant", "P03") == 2
    assert "a table [session]" in capsys.readouterr().err


def test_devices_and_typed_lines(
    study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = "help\nplace S1\ndrop 2\ndrop much\nunpair 5\nunpair 99\nflood\npage http://127.0.0.1:9/\nquit\n"
    monkeypatch.setattr("sys.stdin", io.StringIO(lines))
    assert emulate(study, "--participant", "P03", "--truth", str(tmp_path / "truth.json")) == 0
    said = capsys.readouterr().out
    for part in (
        "Trigno server at 127.0.0.1", "Net F/T box", "unpair N               the sensor",
        "done: place S1", "done: drop 2", "drop: expected a number",
        "unpair: expected a number", "'flood' is none of", "a page of a running session", "end of the emulation",
    ):  # fmt: skip
        assert part in said
    assert json.loads((tmp_path / "truth.json").read_text())["participant"] == "P03"


def test_json_is_one_object_with_the_addresses(
    study: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO("place S1\nquit now\n"))
    assert emulate(study, "--participant", "P03", "--json") == 0
    told = capsys.readouterr()
    found = json.loads(told.out)
    assert found["participant"] == "P03"
    assert found["addresses"]["emg"]["kind"] == "trigno"
    assert f"emg_port = {found['addresses']['emg']['ports']['emg']}" in study.read_text(encoding="utf-8")
    rig = study.with_name("rig.toml").read_text(encoding="utf-8")
    assert f"rdt_port = {found['addresses']['force']['rdt_port']}" in rig
    assert "done: place S1" in told.err
    assert "end of the emulation" in told.err
