"""The dataset against the standard's own validator, and the side files against the data."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest

from emg2vsa.errors import SettingError
from emg2vsa.study import Study
from emg2vsa.worlds.people.study import simulate_study

Make = Callable[..., Study]
KNOWN_WARNINGS = {"TOO_FEW_AUTHORS", "JSON_KEY_RECOMMENDED"}
"""One author (a program), and no HED tags or source datasets: nothing that could be given."""


@pytest.fixture
def validate() -> Callable[[Path], list[dict[str, str]]]:
    """Issues the validator finds in a dataset."""
    program = shutil.which("bids-validator-deno", path=str(Path(sys.executable).parent))
    if program is None:
        pytest.skip("bids-validator-deno is not installed (extra 'test')")

    def run(folder: Path) -> list[dict[str, str]]:
        done = subprocess.run([program, str(folder), "--format", "json"], capture_output=True, text=True, timeout=300)
        return list(json.loads(done.stdout)["issues"]["issues"])

    return run


def test_side_files_agree_with_the_data(study: Study, tmp_path: Path) -> None:
    path = simulate_study(study, tmp_path).recordings[0]
    assert path.relative_to(tmp_path).as_posix() == "sub-P01/emg/sub-P01_task-palpation_acq-S1_emg.bdf"
    side = json.loads(path.with_suffix(".json").read_text())
    channels = pd.read_csv(path.with_name(path.name.replace("_emg.bdf", "_channels.tsv")), sep="\t")
    assert channels.name.tolist() == ["EDC", "FDS", "Fz"]
    assert channels.type.tolist() == ["EMG", "EMG", "MISC"]
    assert channels.units.tolist() == ["uV", "uV", "N"]
    assert channels.target_muscle.tolist()[:2] == ["extensor digitorum communis", "flexor digitorum superficialis"]
    assert (side["EMGChannelCount"], side["MiscChannelCount"]) == (2, 1)
    header = path.read_bytes()[:256]
    assert header[:8] == b"\xffBIOSEMI"
    assert side["RecordingDuration"] == int(header[236:244]) * float(header[244:252])


def test_scans_list_every_recording_in_time_order(study_with: Make, tmp_path: Path) -> None:
    simulate_study(study_with(participants=2, specimens=5, repetitions=1), tmp_path)
    for subject in ("sub-P01", "sub-P02"):
        scans = pd.read_csv(tmp_path / subject / f"{subject}_scans.tsv", sep="\t")
        assert scans.acq_time.is_monotonic_increasing
        assert {tmp_path / subject / name for name in scans.filename} == set((tmp_path / subject).rglob("*.bdf"))


def test_task_label_is_that_of_the_study_file(study: Study, tmp_path: Path) -> None:
    named = tuple(
        replace(entry, emg_file=Path(f"sub-{entry.participant}_task-press_acq-{entry.specimen}_emg.bdf"))
        for entry in study.recordings
    )
    made = simulate_study(replace(study, recordings=named), tmp_path)
    assert [path.name for path in made.recordings] == [entry.emg_file.name for entry in named]
    assert (tmp_path / "task-press_events.json").exists()


def test_the_validator_finds_no_error_and_would_find_one(
    study: Study, tmp_path: Path, validate: Callable[[Path], list[dict[str, str]]]
) -> None:
    made = simulate_study(study, tmp_path)
    issues = validate(tmp_path)
    assert [issue for issue in issues if issue["severity"] == "error"] == []
    assert {issue["code"] for issue in issues} <= KNOWN_WARNINGS
    truth = made.truth.parent
    assert json.loads((truth / "dataset_description.json").read_text())["DatasetType"] == "derivative"
    assert [issue for issue in validate(truth) if issue["severity"] == "error"] == []
    path = made.recordings[0].with_suffix(".json")
    side = json.loads(path.read_text())
    del side["PowerLineFrequency"]
    path.write_text(json.dumps(side))
    assert any(issue["severity"] == "error" for issue in validate(tmp_path))


def test_names_that_are_no_labels_are_refused_before_anything_is_written(study: Study, tmp_path: Path) -> None:
    odd = tuple(replace(entry, participant="P_1") for entry in study.recordings)
    with pytest.raises(SettingError, match="P_1"):
        simulate_study(replace(study, participants=("P_1",), recordings=odd), tmp_path)
    assert list(tmp_path.iterdir()) == []
