"""A registered study: the study and rig files of the demo, with files in place of recordings that nobody decodes."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from benchmarks.planted_deviations import RegisteredStudy, register_in


@pytest.fixture(scope="session")
def registered_once(tmp_path_factory: pytest.TempPathFactory) -> RegisteredStudy:
    return register_in(tmp_path_factory.mktemp("registered") / "palpation")


@pytest.fixture
def study(registered_once: RegisteredStudy, tmp_path: Path) -> RegisteredStudy:
    """A copy in another place, to be changed."""
    return RegisteredStudy(Path(shutil.copytree(registered_once.folder, tmp_path / "elsewhere")))
