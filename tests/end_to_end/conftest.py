"""A small study, simulated once: two participants, three specimens, four presses."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from benchmarks.small_study import small_study
from emg2vsa.cli import main
from tests import small
from tests.once import Once

STUDY = small_study(
    simulation="seed = 3\nrepetitions = 4\n",
    tables="""
[window]
expected_trials = 4
[profile]
new_specimen = "S_new"
new_stiffness_n_per_mm = 5.32
""",
)


@pytest.fixture(scope="session")
def simulated(built_once: Once) -> Path:
    """Folder with the study file and its recordings; copied, never changed."""
    return built_once("simulated", lambda root: small.simulated(root, STUDY)) / "studies" / "small"


@pytest.fixture
def study(simulated: Path, tmp_path: Path) -> Path:
    """A copy of the simulated study's file, to run and to change."""
    folder = tmp_path / "studies" / "small"
    shutil.copytree(simulated, folder)
    return folder / "study.toml"


@pytest.fixture(scope="session")
def ran_once(simulated: Path, built_once: Once) -> Path:
    """Folder two levels above a study that was run to its report."""

    def run(root: Path) -> None:
        shutil.copytree(simulated, root / "studies" / "small")
        assert main(["run", str(root / "studies" / "small" / "study.toml"), "--jobs", "1", "--json"]) == 0

    return built_once("ran", run)


@pytest.fixture
def ran(ran_once: Path, tmp_path: Path) -> Path:
    """A study file whose run is complete. The copy keeps file times, so that nothing looks changed but the inodes."""
    root = tmp_path / "ran"
    shutil.copytree(ran_once, root)
    study = root / "studies" / "small" / "study.toml"
    assert main(["run", str(study), "--jobs", "1", "--json"]) == 0
    return study


@pytest.fixture(scope="session")
def packaged_once(ran_once: Path, built_once: Once) -> Path:
    """``ran_once`` with the authors' package of the study."""

    def package(root: Path) -> None:
        shutil.copytree(ran_once, root, dirs_exist_ok=True)
        assert main(["report", str(root / "studies/small/study.toml"), "--paper", "--jobs", "1", "--json"]) == 0

    return built_once("packaged", package)
