"""Simulated presses on disk, made once."""

from __future__ import annotations

from pathlib import Path

import pytest

from casr.cli import main


@pytest.fixture(scope="session")
def presses(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A hard and a soft specimen, two presses each, written by the command."""
    folder = tmp_path_factory.mktemp("simulated") / "presses"
    assert main(["simulate", str(folder), "--specimens", "S1,S5", "--angles", "0", "--repetitions", "2"]) == 0
    return folder
