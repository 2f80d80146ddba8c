"""Who works at a step, and files that steps wrote outside the store."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

import pytest

from emg2vsa import artifacts
from emg2vsa.held_lock import told
from emg2vsa.pipeline.fingerprint import Fingerprints
from emg2vsa.pipeline.store import ClaimedElsewhere, Store, claimed, remove_left_files, written_files


def test_a_step_is_claimed_by_one_process_at_a_time(tmp_path: Path) -> None:
    claim = Store(tmp_path).claim("fits/P1/S1")
    with claimed(claim):
        with (
            pytest.raises(ClaimedElsewhere, match=rf"found process {os.getpid()} on .*, since \d\d:\d\d"),
            claimed(claim),
        ):
            pass
        with claimed(Store(tmp_path).claim("fits/P1/S2")):
            pass
        assert claim.exists()
    with claimed(claim):
        pass
    with pytest.raises(ZeroDivisionError), claimed(claim):
        raise ZeroDivisionError
    assert not claim.exists()


@pytest.mark.parametrize("content", ["", "5", "{}", '{"pid": 1, "host": "x", "since": "yesterday"}'])
def test_a_claim_that_cannot_be_read_is_another_process(tmp_path: Path, content: str) -> None:
    (tmp_path / "claim").write_text(content)
    assert told(tmp_path / "claim") == "another process"


def test_sweep_removes_what_killed_processes_left_and_nothing_else(tmp_path: Path) -> None:
    store = Store(tmp_path)
    store.sweep()
    result = Path(store.path("fits/P1/S1", "k"))
    for path in (store.unfinished("fits/P1/S1", "k"), store.claim("fits/P1/S1"), result):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps({}))
    store.sweep()
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == [result]


def test_settled_results_are_found_kept_and_dropped(tmp_path: Path) -> None:
    store = Store(tmp_path)
    for key in ("k1", "k2", "k3"):
        unfinished = store.unfinished("fits/P1/S1", key)
        unfinished.parent.mkdir(exist_ok=True)
        unfinished.write_text(key)
        assert Path(store.settle(unfinished, "fits/P1/S1", key)).read_text() == key
        assert not unfinished.exists()
    assert [path.stem for path in store.results("fits/P1/S1")] == ["k1", "k2", "k3"]
    assert [path.stem for path in store.keep_only("fits/P1/S1", ["k2"])] == ["k1", "k3"]
    assert [path.stem for path in store.results("fits/P1/S1")] == ["k2"]
    assert list(store.stored_steps()) == ["fits/P1/S1"]
    store.keep_only("fits/P1/S1", [])
    store.drop_empty_folders()
    assert not (tmp_path / "store").exists()


def wrote(project: Path, names: str, key: str, text: str = "") -> Path:
    """A step's run that wrote these files, what earlier ones left over removed; its result."""
    folder, store = project / "reports", project / "store"
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        (folder / name).write_text(text or name)
    written = written_files(folder, [folder / name for name in names])
    remove_left_files(folder, sorted(store.glob("*.result")), written)
    artifacts.save(store / f"{key}.result", written)
    return store / f"{key}.result"


def trouble(project: Path, result: Path) -> str:
    return str(artifacts.load(result).trouble(project / "reports", Fingerprints(project / "memory.json")))


def test_a_changed_or_missing_file_is_told(tmp_path: Path) -> None:
    result = wrote(tmp_path, "ab", "1")
    assert trouble(tmp_path, result) == ""
    (tmp_path / "reports" / "a").write_text("A")  # as long as it was
    assert trouble(tmp_path, result) == "its file a was changed"
    (tmp_path / "reports" / "a").write_text("a")
    assert trouble(tmp_path, result) == ""
    (tmp_path / "reports" / "b").unlink()
    assert trouble(tmp_path, result) == "its file b is missing"


def test_what_only_an_earlier_result_wrote_goes(tmp_path: Path) -> None:
    wrote(tmp_path, "ab", "1")
    (tmp_path / "reports" / "mine").write_text("of a person")
    (tmp_path / "store" / "damaged.result").write_text("")
    wrote(tmp_path, "bc", "2")
    assert sorted(path.name for path in (tmp_path / "reports").iterdir()) == ["b", "c", "mine"]


def test_the_copy_of_a_project_leaves_the_original_alone(tmp_path: Path) -> None:
    wrote(tmp_path / "original", "ab", "1")
    shutil.copytree(tmp_path / "original", tmp_path / "copy")
    again = wrote(tmp_path / "copy", "bc", "2", text="another")
    assert trouble(tmp_path / "copy", again) == ""
    assert {path.name: path.read_text() for path in (tmp_path / "original" / "reports").iterdir()} == {
        "a": "a",
        "b": "b",
    }
    assert sorted(path.name for path in (tmp_path / "copy" / "reports").iterdir()) == ["b", "c"]
