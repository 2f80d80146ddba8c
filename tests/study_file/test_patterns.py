"""Files found by patterns with * and {repetition}."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from emg2vsa.study import Study
from emg2vsa.study_file import missing_files

PATTERN = 'pattern = "data/{participant}_{specimen}.csv"'
Load = Callable[[str], Study]


def touch(tmp_path: Path, *names: str) -> None:
    for name in names:
        path = tmp_path / "studies" / "small" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()


def names(study: Study) -> dict[str, list[str]]:
    return {entry.key: [part.emg_file.name for part in entry.parts] for entry in study.recordings}


def test_a_star_stands_for_one_text(tmp_path: Path, small: str, load: Load) -> None:
    touch(tmp_path, "data/2026-05-01_P01_S1.csv", "data/2026-05-02_P01_S3.csv", "data/x_P02_S1.csv", "data/P02_S3.csv")
    study = load(small.replace(PATTERN, 'pattern = "data/*_{participant}_{specimen}.csv"'))
    assert names(study)["P01/S1"] == ["2026-05-01_P01_S1.csv"]
    assert names(study)["P02/S3"] == ["*_P02_S3.csv"]  # none: the pattern tells what was looked for
    assert [entry.key for entry in missing_files(study)] == ["P02/S3"]
    assert study.data.name == "data"


def test_several_matches_are_refused_with_their_names(tmp_path: Path, small: str, load: Load) -> None:
    touch(tmp_path, "data/1_P01_S1.csv", "data/2_P01_S1.csv")
    study = load(small.replace(PATTERN, 'pattern = "data/*_{participant}_{specimen}.csv"'))
    entry = next(entry for entry in study.recordings if entry.key == "P01/S1")
    assert entry.fault == "2 files, 1_P01_S1.csv, 2_P01_S1.csv"
    assert not any(entry.fault for entry in study.recordings if entry.key != "P01/S1")


def test_a_file_of_two_cells_is_refused(tmp_path: Path, small: str, load: Load) -> None:
    touch(tmp_path, "data/P01_S1_S3.csv")
    study = load(small.replace(PATTERN, 'pattern = "data/{participant}_*{specimen}*.csv"'))
    faults = {entry.key: entry.fault for entry in study.recordings}
    assert faults["P01/S1"] == "P01_S1_S3.csv, which matches for P01/S3 too"
    assert faults["P01/S3"] == "P01_S1_S3.csv, which matches for P01/S1 too"


def test_repetitions_are_in_the_order_of_their_numbers(tmp_path: Path, small: str, load: Load) -> None:
    touch(tmp_path, *(f"data/P01_S1_{n}.csv" for n in (10, 2, 1)), "data/P01_S1_x.csv", "data/P01_S3_007.csv")
    study = load(small.replace(PATTERN, 'pattern = "data/{participant}_{specimen}_{repetition}.csv"'))
    assert names(study)["P01/S1"] == ["P01_S1_1.csv", "P01_S1_2.csv", "P01_S1_10.csv"]
    assert names(study)["P01/S3"] == ["P01_S3_007.csv"]


def test_one_repetition_twice_is_refused(tmp_path: Path, small: str, load: Load) -> None:
    touch(tmp_path, "data/P01_S1_1.csv", "data/P01_S1_01.csv", "data/P01_S1_2.csv")
    study = load(small.replace(PATTERN, 'pattern = "data/{participant}_{specimen}_{repetition}.csv"'))
    entry = next(entry for entry in study.recordings if entry.key == "P01/S1")
    assert [part.fault for part in entry.parts] == ["2 files, P01_S1_01.csv, P01_S1_1.csv", ""]


def test_force_files_go_with_their_repetition(tmp_path: Path, small: str, load: Load) -> None:
    touch(tmp_path, "data/P01_S1_1_e.csv", "data/P01_S1_2_e.csv", "data/P01_S1_2_f.csv")
    both = 'pattern = "data/{participant}_{specimen}_{repetition}_e.csv"\n'
    both += 'force_pattern = "data/{participant}_{specimen}_{repetition}_f.csv"'
    entry = next(e for e in load(small.replace(PATTERN, both)).recordings if e.key == "P01/S1")
    assert [part.force_file.name if part.force_file else None for part in entry.parts] == [
        "P01_S1_{repetition}_f.csv",
        "P01_S1_2_f.csv",
    ]


def test_listed_recordings_of_one_cell_follow_each_other(small: str, load: Load) -> None:
    more = '[[recordings.files]]\nparticipant = "P01"\nspecimen = "S1"\nemg = "{}.csv"\n'
    channel = 'channels.force = {{ name = "Fz", sign = -1 }}\n'
    study = load(small + more.format("a") + more.format("b") + channel.format())
    entry = next(entry for entry in study.recordings if entry.key == "P01/S1")
    assert [part.emg_file.name for part in entry.parts] == ["a.csv", "b.csv"]
    assert [part.channels.force.sign for part in entry.parts] == [1, -1]


@pytest.mark.parametrize("names", [("run-1", "run-02"), ("run-02", "run-1")])
def test_runs_of_a_bids_folder(tmp_path: Path, small: str, load: Load, names: tuple[str, ...]) -> None:
    touch(tmp_path, *(f"d/sub-P01/emg/sub-P01_task-t_acq-S1_{name}_emg.bdf" for name in names))
    study = load(small.replace('layout = "pattern"\n' + PATTERN, 'layout = "bids"\nroot = "d"\ntask = "t"'))
    found = next(entry for entry in study.recordings if entry.key == "P01/S1").parts
    assert [part.emg_file.name.split("_")[3] for part in found] == ["run-1", "run-02"]
