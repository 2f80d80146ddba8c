"""Whatever is done to stored results and written files of a real study is noticed, and mended by running it again."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from pathlib import Path

import pytest

from emg2vsa.cli import main
from emg2vsa.pipeline.fingerprint import Fingerprints, state_of
from emg2vsa.pipeline.plan import Step, survey
from emg2vsa.pipeline.stage_order import ORDER, stage
from emg2vsa.study_file import load_study

DAMAGED, MISSING = ("its result was damaged",), ("its result is missing",)


def run(study: Path, *more: str) -> int:
    return main(["run", str(study), "--jobs", "1", "--json", *more])


def look(study: Path) -> dict[str, Step]:
    return survey(load_study(study), ORDER, lambda text: pytest.fail(text)).steps


def stale(study: Path) -> dict[str, tuple[str, ...]]:
    """Steps that are to run again, with their reasons."""
    return {step.id: step.reasons for step in look(study).values() if step.status == "stale"}


def all_files(study: Path) -> dict[str, bytes]:
    """Every stored result, and every file that steps wrote, the report's above all."""
    root = study.parent.parent.parent
    folders = (study.parent / ".emg2vsa" / "small" / "store", study.parent / "runs-virtual", root / "reports")
    return {str(path): path.read_bytes() for folder in folders for path in folder.rglob("[!.]*") if path.is_file()}


def result_of(study: Path, step: str) -> Path:
    (path,) = (study.parent / ".emg2vsa" / "small" / "store" / step).glob("*.result")
    return path


def flip(path: Path, draw: random.Random) -> None:
    data = bytearray(path.read_bytes())
    data[draw.randrange(len(data))] ^= 1 << draw.randrange(8)
    path.write_bytes(data)


def test_flipped_bits_in_every_kind_of_result_are_noticed_and_made_again(study: Path) -> None:
    whole, steps, draw = all_files(study), list(look(study)), random.Random(4)
    always = [name for name in ORDER if not stage(name).on_request]
    one_of_each = [draw.choice([step for step in steps if step.startswith(f"{name}/")]) for name in always]
    for step in one_of_each:
        path = result_of(study, step)
        flip(path, draw)
        assert stale(study) == {step: DAMAGED}
        path.write_bytes(whole[str(path)])
    for step in one_of_each:
        flip(result_of(study, step), draw)
    assert run(study) == 0
    assert all_files(study) == whole
    assert {step.status for step in look(study).values()} == {"fresh"}


@pytest.mark.parametrize(
    ("harm", "reason"),
    [
        (lambda path: path.write_bytes(path.read_bytes()[:-9]), DAMAGED),
        (lambda path: path.write_bytes(b""), DAMAGED),
        (lambda path: path.write_bytes(b"\x80\x04pickle"), DAMAGED),
        (lambda path: path.unlink(), MISSING),
    ],
    ids=["truncated", "emptied", "replaced", "deleted"],
)
def test_a_harmed_result_is_made_again_by_itself(
    study: Path, harm: Callable[[Path], None], reason: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    whole, steps = all_files(study), ("trials/P01/S1", "fits/P02/S3", "hypotheses/study", "pages/P02")
    for step in steps:
        harm(result_of(study, step))
    found = stale(study)
    assert found["trials/P01/S1"] == reason
    assert found["fits/P02/S3"] == reason
    capsys.readouterr()
    assert run(study) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["failures"] == []
    assert sorted(told["ran"]) == sorted(steps)
    assert all_files(study) == whole


def test_changed_and_deleted_files_of_steps_are_noticed_and_made_again(study: Path) -> None:
    whole = all_files(study)
    runs, reports = study.parent / "runs-virtual", study.parent.parent.parent / "reports" / "small"
    flip(runs / "S1_0_modular" / "press-001" / "frames.tif", random.Random(1))
    (runs / "S3_0_modular" / "press-002" / "force.csv").unlink()
    pages = sorted(reports.rglob("*.html"))
    page = next(path for path in pages if path.name == "index.html")
    page.write_text(page.read_text().replace("a", "b", 1))
    found = stale(study)
    assert found == {
        "emulation/S1_0_modular": ("its file S1_0_modular/press-001/frames.tif was changed",),
        "emulation/S3_0_modular": ("its file S3_0_modular/press-002/force.csv is missing",),
    }
    assert look(study)["report/study"].status == "waits"
    assert run(study) == 0
    assert all_files(study) == whole


def test_damage_that_the_state_of_the_file_does_not_tell_heals_in_the_run_that_meets_it(
    study: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A disk that changes bytes by itself changes no times."""
    whole, path = all_files(study), result_of(study, "fits/P01/S3")
    flip(path, random.Random(2))
    prints = Fingerprints(study.parent / ".emg2vsa" / "small" / "fingerprints.json")
    prints._known[str(path)][0] = list(state_of(path) or ())
    prints._changed = True
    prints.save()
    assert stale(study) == {}
    result_of(study, "hypotheses/study").unlink()
    capsys.readouterr()
    assert run(study) == 0
    assert json.loads(capsys.readouterr().out)["failures"] == []
    assert all_files(study) == whole


def test_damaged_books_are_one_warning_each_and_made_anew(study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A result of which no record tells what it used is made again, to the same bytes; nothing ends in a traceback."""
    books, whole = study.parent / ".emg2vsa" / "small", all_files(study)
    for name in ("ledger.jsonl", "fingerprints.json"):
        (books / name).write_bytes(b"\xff\xfe\n")
    capsys.readouterr()
    assert main(["run", str(study), "--jobs", "1", "--json", "--only", "hypotheses"]) == 0
    captured = capsys.readouterr()
    ran = json.loads(captured.out)["ran"]
    assert {step.partition("/")[0] for step in ran} == {"trials", "fits", "screening", "hypotheses"}
    warnings = [line for line in captured.err.splitlines() if " is damaged" in line]
    assert len(warnings) == 2
    assert all_files(study) == whole
    assert main(["status", str(study), "--json"]) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    assert json.loads(captured.out)["hypotheses/study"]["status"] == "fresh"
