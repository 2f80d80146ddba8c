"""Folders of new runs beside those that are there."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from emg2vsa.errors import DataError
from emg2vsa.rig.record.new_folder import EMULATED_FILE, how_ended, new_folder, presses_done, presses_left
from emg2vsa.rig.record.press_counts import PRESSES_FILE


def make(folder: Path, how: str | None, done: int = 10) -> None:
    folder.mkdir(parents=True)
    if how is not None:
        (folder / "ended.json").write_text(json.dumps({"how": how, "repetitions_done": done}))


def test_the_first_free_name(tmp_path: Path) -> None:
    runs = tmp_path / "runs"
    assert new_folder(runs, "S1_0_modular", 10, emulated=False) == runs / "S1_0_modular"
    for number, how in enumerate(("killed", "guard", None), start=1):
        make(runs / ("S1_0_modular" if number == 1 else f"S1_0_modular-{number}"), how, done=0)
        assert new_folder(runs, "S1_0_modular", 10, emulated=False) == runs / f"S1_0_modular-{number + 1}"
    assert presses_left(runs, "S1_0_modular", 10, emulated=False) == 10
    assert not (runs / "S1_0_modular-4").exists()
    assert new_folder(runs, "S1_30_modular", 10, emulated=False) == runs / "S1_30_modular"


@pytest.mark.parametrize("before", [(), (0,), (4, 0), (9, 3)])
def test_a_run_with_all_its_presses_is_refused(before: tuple[int, ...], tmp_path: Path) -> None:
    names = ["S1_0_modular", "S1_0_modular-2", "S1_0_modular-3"]
    for name, done in zip(names, before, strict=False):
        make(tmp_path / name, "guard", done)
    make(tmp_path / names[len(before)], "completed", 10 - min(10, sum(before)))
    assert presses_left(tmp_path, "S1_0_modular", 10, emulated=False) == 0
    with pytest.raises(
        DataError, match="expected a run that is still to do, but found one with all its presses"
    ) as caught:
        new_folder(tmp_path, "S1_0_modular", 10, emulated=False)
    assert caught.value.where == str(tmp_path / "S1_0_modular")


def test_a_trial_of_fewer_presses_counts_and_the_others_are_still_to_do(tmp_path: Path) -> None:
    make(tmp_path / "S1_0_modular", "completed", done=2)
    assert presses_left(tmp_path, "S1_0_modular", 10, emulated=False) == 8
    assert new_folder(tmp_path, "S1_0_modular", 10, emulated=False) == tmp_path / "S1_0_modular-2"


@pytest.mark.parametrize(("how", "done", "good"), [("rejected", 3, 2), ("guard", 2, 1), ("killed", 0, 2)])
def test_rejected_presses_do_not_count(how: str, done: int, good: int, tmp_path: Path) -> None:
    """Of a run that a guard ended the press under way does not count; a killed one has no count of its own."""
    make(tmp_path / "S1_0_modular", how, done)
    rows = "repetition,verdict,why\n1,ok,\n2,rejected,lost\n3,doubtful,late\n"
    (tmp_path / "S1_0_modular" / PRESSES_FILE).write_text(rows)
    assert presses_left(tmp_path, "S1_0_modular", 10, emulated=False) == 10 - good


@pytest.mark.parametrize("text", ["", "{", "[]", "{}", "3"])
def test_an_ending_that_cannot_be_read_is_none(text: str, tmp_path: Path) -> None:
    (tmp_path / "ended.json").write_text(text)
    assert how_ended(tmp_path) is None
    assert presses_done(tmp_path) == 0


@pytest.mark.parametrize("emulated", [False, True])
def test_runs_of_the_other_kind_do_not_count(emulated: bool, tmp_path: Path) -> None:
    make(tmp_path / "S1_0_modular", "completed")
    if not emulated:
        (tmp_path / "S1_0_modular" / EMULATED_FILE).write_text("{}")
    assert presses_left(tmp_path, "S1_0_modular", 10, emulated=emulated) == 10
    assert presses_left(tmp_path, "S1_0_modular", 10, emulated=not emulated) == 0
    assert new_folder(tmp_path, "S1_0_modular", 10, emulated=emulated) == tmp_path / "S1_0_modular-2"
