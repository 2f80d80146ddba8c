"""A folder in the place of a file of ours, or a file in that of a folder: named as what it is, mended, and kept."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from emg2vsa.cli import main
from tests.pipeline.test_damage import all_files, result_of, run, stale


def folder_in_place(path: Path) -> None:
    path.unlink()
    path.mkdir()
    (path / "mine.txt").write_text("mine")


def file_in_place(path: Path) -> None:
    for each in path.iterdir():
        each.unlink()
    path.rmdir()
    path.write_text("mine")


PLACES: dict[str, tuple[Callable[[Path], Path], Callable[[Path], None], str]] = {
    "result": (lambda study: result_of(study, "fits/P01/S1"), folder_in_place, "a folder is in place of its result"),
    "step": (lambda study: result_of(study, "fits/P01/S1").parent, file_in_place, "its result is missing"),
    "ledger": (lambda study: study.parent / ".emg2vsa" / "small" / "ledger.jsonl", folder_in_place, ""),
}


@pytest.mark.parametrize("place", PLACES)
def test_it_is_set_aside_and_the_result_made_again(study: Path, place: str) -> None:
    of, harm, reason = PLACES[place]
    whole, path = all_files(study), of(study)
    harm(path)
    if reason:
        assert stale(study) == {"fits/P01/S1": (reason,)}
    assert run(study, "--paths") == 0  # who has lost the ledger has forgotten that they were asked for
    assert all_files(study) == whole
    (kept,) = (study.parent / ".emg2vsa" / "small" / "set-aside").iterdir()
    assert kept.name == f"{path.name}-1"
    assert (kept / "mine.txt" if kept.is_dir() else kept).read_text() == "mine"
    assert main(["tools", "clean", str(study), "--json"]) == 0
    assert kept.exists()
    assert stale(study) == {}


def test_one_in_the_report_is_named(study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = study.parents[2] / "reports" / "small" / "results.json"
    folder_in_place(page)
    capsys.readouterr()
    assert main(["run", str(study), "--jobs", "1"]) == 1
    said = f"{page}: A folder is in place of this file. Mend that, and run the study again."
    assert said in capsys.readouterr().err
    assert (page / "mine.txt").read_text() == "mine"
