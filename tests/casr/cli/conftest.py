"""Simulated presses on disk, made once."""

from __future__ import annotations

from pathlib import Path

import pytest

from casr.cli import main


@pytest.fixture(scope="session")
def presses(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A hard and a soft specimen, two presses each, written by the command."""
    folder = tmp_path_factory.mktemp("simulated") / "presses"
    words = ["--specimens", "S1,S5", "--angles", "0", "--repetitions", "2", "--scatter", "none"]
    assert main(["simulate", str(folder), *words]) == 0
    return folder


@pytest.fixture(scope="session")
def stuck_press(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A press in the world in which the skin inside the contact grows as the contact does."""
    folder = tmp_path_factory.mktemp("simulated") / "stuck"
    words = ["--world", "stick", "--specimens", "S5", "--angles", "0", "--repetitions", "1"]
    assert main(["simulate", str(folder), *words]) == 0
    return folder / "S5_00deg_01"
