"""Cleaning removes what no step needs any more, and nothing else."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from emg2vsa.cli import main

pytestmark = pytest.mark.usefixtures("blank_drawings")


def files_below(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_clean_removes_what_no_key_needs(study: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = files_below(tmp_path / "copy")
    store = study.parent / ".emg2vsa" / "small" / "store"
    unneeded = ("fits/P01/S1/0123456789abcdef", "fits/P09/S1/0123456789abcdef", "stage-of-old/study/0123456789abcdef")
    for name in unneeded:
        path = store / f"{name}.result"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"x" * 10)
    left = study.parent / ".emg2vsa" / "small" / "under-way" / "fits%2FP01%2FS1.json"
    left.parent.mkdir(exist_ok=True)
    left.write_text("{}")
    capsys.readouterr()
    assert main(["tools", "clean", str(study), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"removed": 3, "bytes": 30, "moved_to": None}
    assert files_below(tmp_path / "copy") == before
    assert not (store / "fits" / "P09").exists()
    assert main(["status", str(study), "--json"]) == 0
    assert {each["status"] for each in json.loads(capsys.readouterr().out).values()} == {"fresh"}
    assert main(["tools", "clean", str(study)]) == 0
    assert capsys.readouterr().out == f"0 results removed, 0.0 MB, from {store.parent}\n"


def test_results_behind_a_stale_step_are_kept(study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Nobody knows their keys before that step has run: they may turn out as they were."""
    store = study.parent / ".emg2vsa" / "small" / "store"
    shutil.rmtree(store / "trials" / "P01" / "S1")
    before = files_below(store)
    assert main(["tools", "clean", str(study)]) == 0
    assert files_below(store) == before
    capsys.readouterr()
    assert main(["run", str(study), "--jobs", "1", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["ran"] == ["trials/P01/S1"]


def test_virtual_runs_of_0_1_0_are_moved_and_measured_ones_stay(
    study: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    runs, virtual = study.parent / "runs", study.parent / "runs-virtual"
    for name in ("S1_0_modular", "S3_0_modular"):
        shutil.copytree(virtual / name, runs / name)
    (runs / "S3_0_modular" / "emulated.json").unlink()
    capsys.readouterr()
    assert main(["run", str(study), "--only", "runs"]) == 0
    (note,) = (line for line in capsys.readouterr().out.splitlines() if line.startswith("note: "))
    assert "1 run that the emulated rig of version 0.1.0 made" in note
    assert f"emg2vsa tools clean {study} --move-virtual" in note
    moved = study.parent / "runs-virtual-0.1.0"
    assert main(["tools", "clean", str(study), "--move-virtual"]) == 0
    assert f"The virtual runs of version 0.1.0 are now in {moved}" in capsys.readouterr().out
    assert [path.name for path in moved.iterdir()] == ["S1_0_modular"]
    assert [path.name for path in runs.iterdir()] == ["S3_0_modular"]
    assert len(list(virtual.glob("[!.]*"))) == 8
    shutil.copytree(virtual / "S1_0_modular", runs / "S1_0_modular")
    assert main(["tools", "clean", str(study), "--move-virtual"]) == 2
    assert "Move or delete one of the two folders." in capsys.readouterr().err
    assert (runs / "S1_0_modular").is_dir()
