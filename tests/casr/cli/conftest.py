"""Simulated presses on disk, made once."""

from __future__ import annotations

from pathlib import Path

import pytest

from casr.cli import main
from tests.once import Once


def _simulate(folder: Path, *words: str) -> None:
    assert main(["simulate", str(folder), "--scatter", "none", "--angles", "0", *words]) == 0


@pytest.fixture(scope="session")
def presses(built_once: Once) -> Path:
    """A hard and a soft specimen, two presses each, written by the command; never changed."""
    words = ("--specimens", "S1,S5", "--repetitions", "2")
    return built_once("presses", lambda folder: _simulate(folder / "presses", *words)) / "presses"


@pytest.fixture(scope="session")
def stuck_press(built_once: Once) -> Path:
    """A press in the world in which the skin inside the contact grows as the contact does; never changed."""
    words = ("--world", "stick", "--specimens", "S5", "--repetitions", "1")
    return built_once("stuck", lambda folder: _simulate(folder / "presses", *words)) / "presses" / "S5_00deg_01"
