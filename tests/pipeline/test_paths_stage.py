"""Paths of analysis are computed only where somebody asks, and shown only while they are fresh."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from emg2vsa.cli import main
from emg2vsa.pipeline.plan import survey
from emg2vsa.pipeline.stage_order import ORDER
from emg2vsa.study_file import load_study
from tests.small import simulated

pytestmark = pytest.mark.usefixtures("blank_drawings")


def run(study: Path, capsys: pytest.CaptureFixture[str], *more: str) -> list[str]:
    """Steps that ran."""
    capsys.readouterr()
    assert main(["run", str(study), "--jobs", "1", "--json", *more]) == 0
    ran: list[str] = json.loads(capsys.readouterr().out)["ran"]
    return ran


def shown(study: Path) -> bool:
    """Whether the report has paths."""
    reports = study.parent.parent.parent / "reports" / "small"
    there = "paths.count" in json.loads((reports / "results.json").read_text())
    assert there == (reports / "tables" / "paths.csv").is_file()
    assert there == ("run study.toml --paths" not in (reports / "index.html").read_text())
    return there


def change(study: Path, old: str, new: str) -> None:
    text = study.read_text()
    assert old in text
    study.write_text(text.replace(old, new))


def test_what_was_asked_for_is_fresh_and_shown_by_plain_runs(study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert shown(study)
    assert run(study, capsys, "--paths") == []
    assert run(study, capsys) == []
    assert shown(study)
    assert "paths/study" in survey(load_study(study), ORDER, pytest.fail).steps


def test_a_changed_setting_hides_them_until_somebody_asks_again(
    study: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study.write_text(study.read_text() + "\n[claims]\nslope_percent = 12.0\n")
    steps = survey(load_study(study), ORDER, pytest.fail).steps
    assert "paths/study" not in steps
    assert steps["report/study"].status == "stale"
    assert main(["status", str(study), "--explain"]) == 0
    told = capsys.readouterr().out
    assert "stale: paths/study" not in told
    assert run(study, capsys) == ["report/study"]
    assert not shown(study)
    assert run(study, capsys) == []
    assert run(study, capsys, "--paths") == ["paths/study", "report/study"]
    assert shown(study)
    change(study, "slope_percent = 12.0", "slope_percent = 10.0")
    assert run(study, capsys) == ["report/study"]  # those of before are fresh again
    assert shown(study)


def test_what_the_paths_do_not_depend_on_leaves_them_fresh(study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    change(study, 'title = "', 'title = "Another ')
    assert "paths/study" not in run(study, capsys)
    assert shown(study)


def test_only_paths_asks_for_them(study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    study.write_text(study.read_text() + "\n[claims]\nslope_percent = 12.0\n")
    assert run(study, capsys, "--only", "paths") == ["paths/study"]
    assert run(study, capsys, "--only", "calibration") == []


def test_clean_keeps_what_is_fresh_and_removes_what_no_setting_needs(
    study: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    store = study.parent / ".emg2vsa" / "small" / "store" / "paths" / "study"
    before = sorted(store.iterdir())
    assert main(["tools", "clean", str(study), "--json"]) == 0
    assert sorted(store.iterdir()) == before
    study.write_text(study.read_text() + "\n[claims]\nslope_percent = 12.0\n")
    assert main(["tools", "clean", str(study), "--json"]) == 0
    assert not store.exists()


@pytest.mark.parametrize("other", [["--only", "fits"], ["--human-only"], ["--casr-only"]])
def test_paths_are_of_the_whole_study(study: Path, other: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(["run", str(study), "--paths", *other])
    assert stopped.value.code == 2
    said = capsys.readouterr().err
    assert "--paths" in said
    assert other[0] in said


def test_a_run_that_nobody_asked_never_computes_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from benchmarks.small_study import small_study

    study = simulated(tmp_path, small_study())
    assert not [step for step in run(study, capsys) if step.startswith("paths/")]
    assert not shown(study)
    assert "paths/study" not in survey(load_study(study), ORDER, pytest.fail).steps
    assert run(study, capsys, "--paths") == ["paths/study", "report/study"]
    assert shown(study)


def test_a_damaged_result_is_not_shown_and_is_made_again_on_request(
    study: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (path,) = (study.parent / ".emg2vsa" / "small" / "store" / "paths" / "study").iterdir()
    whole = path.read_bytes()
    path.write_bytes(whole[:-9])
    assert run(study, capsys) == ["report/study"]
    assert not shown(study)
    assert run(study, capsys, "--paths") == ["paths/study", "report/study"]
    assert path.read_bytes() == whole
