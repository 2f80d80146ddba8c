"""Folders of new runs beside those that are there."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from emg2vsa.errors import DataError
from emg2vsa.rig.record.new_folder import EMULATED_FILE, completed_folder, how_ended, new_folder, presses_done


def make(folder: Path, how: str | None, done: int = 10) -> None:
    folder.mkdir(parents=True)
    if how is not None:
        (folder / "ended.json").write_text(json.dumps({"how": how, "repetitions_done": done}))


def test_the_first_free_name(tmp_path: Path) -> None:
    runs = tmp_path / "runs"
    assert new_folder(runs, "S1_0_modular", 10, emulated=False) == runs / "S1_0_modular"
    for number, how in enumerate(("killed", "guard", None), start=1):
        make(runs / ("S1_0_modular" if number == 1 else f"S1_0_modular-{number}"), how)
        assert new_folder(runs, "S1_0_modular", 10, emulated=False) == runs / f"S1_0_modular-{number + 1}"
    assert completed_folder(runs, "S1_0_modular", 10, emulated=False) is None
    assert not (runs / "S1_0_modular-4").exists()
    assert new_folder(runs, "S1_30_modular", 10, emulated=False) == runs / "S1_30_modular"


@pytest.mark.parametrize("before", [(), ("guard",), ("killed", "stopped")])
def test_a_completed_run_is_refused(before: tuple[str, ...], tmp_path: Path) -> None:
    names = ["S1_0_modular", "S1_0_modular-2", "S1_0_modular-3"]
    for name, how in zip(names, (*before, "completed"), strict=False):
        make(tmp_path / name, how)
    done = tmp_path / names[len(before)]
    assert completed_folder(tmp_path, "S1_0_modular", 10, emulated=False) == done
    with pytest.raises(DataError, match="wanted a run that is still to do; found a completed one") as caught:
        new_folder(tmp_path, "S1_0_modular", 10, emulated=False)
    assert caught.value.where == str(done)


def test_a_trial_of_fewer_presses_is_kept_and_the_run_is_still_to_do(tmp_path: Path) -> None:
    make(tmp_path / "S1_0_modular", "completed", done=2)
    assert completed_folder(tmp_path, "S1_0_modular", 10, emulated=False) is None
    assert new_folder(tmp_path, "S1_0_modular", 10, emulated=False) == tmp_path / "S1_0_modular-2"
    make(tmp_path / "S1_0_modular-2", "completed", done=10)
    assert completed_folder(tmp_path, "S1_0_modular", 10, emulated=False) == tmp_path / "S1_0_modular-2"


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
    assert completed_folder(tmp_path, "S1_0_modular", 10, emulated=emulated) is None
    assert completed_folder(tmp_path, "S1_0_modular", 10, emulated=not emulated) == tmp_path / "S1_0_modular"
    assert new_folder(tmp_path, "S1_0_modular", 10, emulated=emulated) == tmp_path / "S1_0_modular-2"
