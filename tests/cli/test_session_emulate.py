"""``emg2vsa session emulate``: one clear error for what cannot be emulated, and devices for what can."""

from __future__ import annotations

import io
import json
import socket
from pathlib import Path

import pytest

from emg2vsa.cli import main

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
