"""A study with people and an emulated rig, and one of its runs as if measured, each run to its report once."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
import tifffile

from emg2vsa.cli import main
from tests.once import Once
from tests.small import run_all, study_of_runs


@pytest.fixture(scope="session")
def finished(built_once: Once) -> Path:
    """Folder of a study with every stage, run to its report; copied, never changed."""
    return built_once("finished", run_all) / "studies" / "small"


@pytest.fixture
def study(finished: Path, tmp_path: Path) -> Path:
    """The study file of a copy of it, whose states have been looked up once."""
    shutil.copytree(finished.parent.parent, tmp_path / "copy")
    path = tmp_path / "copy" / "studies" / "small" / "study.toml"
    assert main(["status", str(path), "--json"]) == 0
    return path


@pytest.fixture(scope="session")
def measured(finished: Path, built_once: Once) -> Path:
    """Folder of a study of measured runs alone, in another place and another format of frames; never changed."""
    return built_once("measured", lambda folder: _run_measured(finished, folder))


def _run_measured(finished: Path, folder: Path) -> None:
    (folder / "study.toml").write_text(study_of_runs("measured", "lab"))
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
    assert main(["run", str(folder / "study.toml"), "--jobs", "1", "--json"]) == 0
