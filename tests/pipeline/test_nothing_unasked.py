"""Nothing is computed that was not asked for: steps, files, samples and frames are counted."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import edfio
import numpy as np
import pytest

from benchmarks.small_study import WITH_A_RIG, small_rig, small_study
from casr.counts import counting
from emg2vsa.cli import main
from emg2vsa.readers.front_door import read
from tests.small import change_a_sample


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a study with a rig whose participants' pages are there; copied, never changed."""
    folder = tmp_path_factory.mktemp("made") / "study"
    folder.mkdir()
    (folder / "study.toml").write_text(small_study(tables=WITH_A_RIG))
    (folder / "rig.toml").write_text(small_rig("modular = [0]\n"))
    assert main(["tools", "simulate", str(folder / "study.toml"), "--json"]) == 0
    assert main(["run", str(folder / "study.toml"), "--only", "schedules", "--jobs", "1", "--json"]) == 0
    return folder


@pytest.fixture
def study(made: Path, tmp_path: Path) -> Path:
    shutil.copytree(made, tmp_path / "study")
    return tmp_path / "study" / "study.toml"


def profile(study: Path, capsys: pytest.CaptureFixture[str], only: str) -> dict[str, dict]:
    capsys.readouterr()
    assert main(["run", str(study), "--only", only, "--profile", "--jobs", "1", "--json"]) == 0
    return {one["stage"]: one for one in json.loads(capsys.readouterr().out)["profile"]}


def computed(found: dict[str, dict]) -> dict[str, int]:
    return {name: own["computed"] for name, own in found.items() if own["computed"]}


def recording(study: Path, participant: str, specimen: str) -> Path:
    (path,) = study.parent.glob(f"data/sub-{participant}/emg/*{specimen}_emg.bdf")
    return path


def test_fits_alone_read_no_frame_and_ask_for_no_other_stage(made: Path, tmp_path: Path, capsys) -> None:
    with counting() as counts:
        assert main(["run", str(made / "study.toml"), "--only", "fits", "--jobs", "1", "--json", "--work",
            str(tmp_path)]) == 0  # fmt: skip
    assert not [what for what in counts if "frame" in what or "pixel" in what]
    assert not any((made / name).exists() for name in ("runs-virtual", "reports"))


def test_one_changed_session_runs_its_own_steps_and_those_of_the_study(study: Path, capsys) -> None:
    change_a_sample(recording(study, "P01", "S1"))
    found = profile(study, capsys, "schedules")
    once = dict.fromkeys(("trials", "fits", "screening", "exemplary", "profiles", "schedules"), 1)
    assert computed(found).items() <= once.items()
    assert {"trials", "fits"} <= computed(found).keys()
    assert found["trials"]["counts"]["files read"] == 1
    assert found["trials"]["reasons"] == {"changed file": 1}
    assert found["fits"]["reasons"] == {"changed input trials": 1}


def test_a_change_that_changes_no_result_goes_no_further(study: Path, capsys) -> None:
    data = bytearray(recording(study, "P01", "S1").read_bytes())
    data[8 : 8 + 80] = b"X X X another_name".ljust(80)  # who it is; no reader asks
    recording(study, "P01", "S1").write_bytes(data)
    assert computed(profile(study, capsys, "schedules")) == {"trials": 1}


def test_nothing_changed_reads_no_recording_and_no_result(study: Path, capsys) -> None:
    with counting() as counts:
        assert computed(profile(study, capsys, "schedules")) == {}
    assert counts == {}


def test_status_decodes_nothing(study: Path) -> None:
    recording(study, "P01", "S1").write_bytes(recording(study, "P02", "S1").read_bytes())
    with counting() as counts:
        assert main(["status", str(study), "--json"]) == 0
    assert counts == {}


def test_only_the_channels_asked_for_are_decoded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rng, n = np.random.default_rng(2), 2000
    signals = [
        edfio.BdfSignal(rng.normal(size=n), 1000, label=f"ch{i}", physical_dimension="uV", physical_range=(-10, 10))
        for i in range(64)
    ]
    edfio.Bdf(signals).write(tmp_path / "many.bdf")
    decoded = []
    data = edfio.BdfSignal.data.fget
    monkeypatch.setattr(edfio.BdfSignal, "data", property(lambda own: decoded.append(own.label) or data(own)))
    with counting() as counts:
        found = read(tmp_path / "many.bdf", ["ch3", "ch60"])
    assert [channel.samples.size for channel in found.channels] == [n, n]
    assert counts["samples decoded"] == 2 * n
    assert counts["bytes read"] == (tmp_path / "many.bdf").stat().st_size
    assert set(decoded) <= {"ch3", "ch60"}


def test_fit_of_one_file_reads_that_file_and_three_channels(study: Path) -> None:
    path = recording(study, "P01", "S1")
    samples = read(path, ["EDC", "FDS", "Fz"]).channels
    with counting() as counts:
        assert main(["fit", str(path), "--emg", "EDC", "--emg", "FDS", "--force", "Fz", "--sign", "-1", "--json"]) in (
            0,
            1,
        )
    assert counts["files read"] == 1
    assert counts["samples decoded"] == sum(channel.samples.size for channel in samples)
