"""A study with people and an emulated rig, and one of its runs as if measured, each run to its report once."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
import tifffile

from emg2vsa.cli import main

STUDY = """
[study]
name = "small"
[participants]
ids = ["P01", "P02"]
[[specimens]]
name = "S1"
stiffness_n_per_mm = 7.63
[[specimens]]
name = "S3"
stiffness_n_per_mm = 3.35
[[specimens]]
name = "S5"
stiffness_n_per_mm = 1.11
[recordings]
layout = "bids"
root = "data"
task = "palpation"
[channels.emg.EDC]
name = "EDC"
[channels.emg.FDS]
name = "FDS"
[channels.force]
name = "Fz"
sign = -1
[window]
expected_trials = 3
[profile]
participant = "P02"
new_specimen = "S_new"
new_stiffness_n_per_mm = 5.32
[runs]
rig = "rig.toml"
[simulation]
seed = 3
repetitions = 3
a_v = { S1 = 42e-6, S3 = 28e-6, S5 = 16e-6 }
b_v = { S1 = 20e-6, S3 = 13e-6, S5 = 7e-6 }
"""
RIG = """
[actuator]
port = "/dev/ttyUSB0"
[motor]
port = "/dev/ttyUSB1"
[force]
kind = "net-ft"
host = "192.168.1.1"
[camera]
source = 0
[experiment]
specimens = ["S1", "S3", "S5", "S_new"]
repetitions = 2
pause_s = 0.1
[experiment.angles_deg]
high-stiffness = [0]
modular = [0]
[emulated]
stiffness_n_per_mm = { S1 = 7.63, S3 = 3.35, S5 = 1.11, S_new = 5.32 }
"""
MEASURED = """
[study]
name = "measured"
[[specimens]]
name = "S1"
stiffness_n_per_mm = 7.63
[[specimens]]
name = "S3"
stiffness_n_per_mm = 3.35
[runs]
root = "lab"
"""


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a study with every stage, run to its report; copied, never changed."""
    folder = tmp_path_factory.mktemp("finished") / "studies" / "small"
    folder.mkdir(parents=True)
    (folder / "study.toml").write_text(STUDY)
    (folder / "rig.toml").write_text(RIG)
    assert main(["simulate", str(folder / "study.toml"), "--json"]) == 0
    assert main(["run", str(folder / "study.toml"), "--json"]) == 0
    return folder


@pytest.fixture
def study(finished: Path, tmp_path: Path) -> Path:
    """The study file of a copy of it, whose states have been looked up once."""
    shutil.copytree(finished.parent.parent, tmp_path / "copy")
    path = tmp_path / "copy" / "studies" / "small" / "study.toml"
    assert main(["status", str(path), "--json"]) == 0
    return path


@pytest.fixture(scope="session")
def measured(finished: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a study of measured runs alone, in another place and another format of frames; never changed."""
    folder = tmp_path_factory.mktemp("measured") / "mine"
    folder.mkdir()
    (folder / "study.toml").write_text(MEASURED)
    rows = ["folder\tspecimen\tangle_deg\tcondition"]
    for specimen in ("S1", "S3"):
        run = finished / "runs-virtual" / f"{specimen}_0_modular"
        for press in sorted(run.glob("press-*")):
            there = folder / "lab" / specimen / press.name
            (there / "frames").mkdir(parents=True)
            for index, image in enumerate(tifffile.imread(press / "frames.tif")):
                tifffile.imwrite(there / "frames" / f"{index:03d}.tif", image)
            shutil.copy(press / "force.csv", there)
        shutil.copy(run / "camera.toml", folder / "lab" / specimen)
        rows.append(f"{specimen}\t{specimen}\t0\tmodular")
    (folder / "lab" / "runs.tsv").write_text("\n".join(rows) + "\n")
    assert main(["run", str(folder / "study.toml"), "--json"]) == 0
    return folder
