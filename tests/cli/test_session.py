"""``emg2vsa session`` at the command line: what it refuses, and a whole session without a page."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from benchmarks.small_study import small_study
from emg2vsa.cli import main
from emg2vsa.session.journal import Judged, line_bytes, read_journal

STUDY = small_study(
    participants=["P03"], specimens=["S1"], muscles=["EDC"], task="press", simulation="muscle_share = { EDC = 1.0 }\n"
)
SESSION = '[session]\nemg.kind = "simulated"\nforce.kind = "simulated"\nrepetitions = 1\n'


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


def test_a_session_in_json_is_one_object_with_its_verdict(study_file, capsys):
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


def test_a_session_is_replayed_from_its_folder(study_file, capsys):
    assert main(["session", str(study_file), "--participant", "P03", "--virtual", "--no-page", "--json"]) == 0
    folder = json.loads(capsys.readouterr().out)["folder"]
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
