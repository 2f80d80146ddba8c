"""Files beside a recording that hold its samples: in the key of its step, and looked at before it is called a copy."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from benchmarks.made_neurophysiology import counts, save_open_ephys
from emg2vsa.cli import main
from emg2vsa.pipeline.campaign import campaign
from emg2vsa.pipeline.plan import Step, survey
from emg2vsa.pipeline.registered import as_it_is
from emg2vsa.pipeline.stages.trials import files
from emg2vsa.readers.sample_files import same_samples, sample_file_paths
from emg2vsa.study_file import load_study
from tests.small import change_a_sample, study_of_files

STREAM = "continuous/Acquisition_Board-100.Rhythm"


def open_ephys(folder: Path, seed: int = 1) -> Path:
    return save_open_ephys(folder, np.column_stack([counts(400, seed), counts(400, seed + 1)]), 2000.0)


def written(folder: Path, *names: str) -> list[Path]:
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(name.encode())
    return sorted(folder / name for name in names)


def test_streams_and_events_of_open_ephys(tmp_path: Path) -> None:
    path = open_ephys(tmp_path)
    own = [tmp_path / STREAM / name for name in ("continuous.dat", "sample_numbers.npy", "timestamps.npy")]
    events = written(tmp_path, "events/Board-100/TTL/states.npy", "events/MessageCenter/text.npy")
    written(tmp_path, "notes.txt", "report/a.npy")
    assert sample_file_paths(path) == tuple(sorted([*own, *events]))


@pytest.mark.parametrize("names", [("amplifier.dat", "time.dat"), ("amp-A-000.dat", "time.dat", "more/amp-A-001.dat")])
@pytest.mark.parametrize("head", ["info.rhd", "info.rhs"])
def test_files_of_intan_for_each_kind_of_signal_or_each_channel(
    tmp_path: Path, head: str, names: tuple[str, ...]
) -> None:
    found = written(tmp_path, *names)
    written(tmp_path, head, "settings.xml", "other.rhd")
    assert sample_file_paths(tmp_path / head) == tuple(found)


@pytest.mark.parametrize("name", ["whole.rhd", "a_emg.edf", "a.csv"])
def test_no_folder_is_listed_for_other_names(tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    written(tmp_path, name, "amplifier.dat", "continuous/a/continuous.dat")
    monkeypatch.setattr(Path, "glob", lambda *_: pytest.fail("listed"))
    assert sample_file_paths(tmp_path / name) == ()


def test_a_copy_is_one_of_its_samples_too(tmp_path: Path) -> None:
    one, other = open_ephys(tmp_path / "1"), open_ephys(tmp_path / "2", 5)
    assert one.read_bytes() == other.read_bytes()
    assert not same_samples(one, other)
    shutil.copytree(tmp_path / "1", tmp_path / "3")
    assert same_samples(one, tmp_path / "3" / other.name)
    (tmp_path / "3" / STREAM / "timestamps.npy").unlink()
    assert not same_samples(one, tmp_path / "3" / other.name)


def reading(study: Path) -> Step:
    (step,) = survey(load_study(study), ("trials",), pytest.fail).steps.values()
    return step


def test_a_changed_sample_makes_the_recording_stale_and_its_data_another(tmp_path: Path) -> None:
    """Whether neo is installed or not: what a failed reading was made of is kept, too."""
    open_ephys(tmp_path / "P01_S1")
    study = tmp_path / "study.toml"
    study.write_text(study_of_files("{participant}_{specimen}/structure.oebin"))
    main(["run", str(study), "--jobs", "1", "--json"])
    registered = as_it_is(load_study(study), None)["data"]
    changed = f"P01_S1/{STREAM}/continuous.dat"
    assert not any(changed in reason for reason in reading(study).reasons)
    change_a_sample(tmp_path / changed)
    assert reading(study).status == "stale"
    assert any(changed in reason for reason in reading(study).reasons)
    assert as_it_is(load_study(study), None)["data"] != registered


def test_side_files_of_maximum_contractions_are_files_of_the_step(tmp_path: Path) -> None:
    written(tmp_path, "P01_S1.csv", "P01_mvc_emg.edf", "P01_mvc_channels.tsv")
    study = tmp_path / "study.toml"
    mvc = '[cocontraction]\nnormalise = "mvc"\n[[mvc]]\nparticipant = "P01"\nemg = "P01_mvc_emg.edf"\n'
    study.write_text(study_of_files() + mvc)
    of = files(campaign(load_study(study)), "P01/S1")
    assert [path.name for path in of["mvc"]] == ["P01_mvc_emg.edf"]
    assert [Path(path).name for path in of["beside"]] == ["P01_mvc_channels.tsv"]
