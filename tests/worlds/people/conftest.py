"""A small study to simulate: two participants, two specimens, two presses each."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from emg2vsa.settings import (
    ChannelSettings,
    EmgChannelSettings,
    FilterSettings,
    ForceChannelSettings,
    SimulationSettings,
    WindowSettings,
)
from emg2vsa.study import RecordingEntry, Specimen, Study

CHANNELS = ChannelSettings(
    emg={"EDC": EmgChannelSettings(name="EDC"), "FDS": EmgChannelSettings(name="FDS")},
    force=ForceChannelSettings(name="Fz", sign=-1),
)


def make_study(
    participants: int = 2, specimens: int = 2, channels: ChannelSettings = CHANNELS, **simulation: Any
) -> Study:
    people = tuple(f"P{i + 1:02d}" for i in range(participants))
    things = tuple(Specimen(f"S{i + 1}", 7.0 - i) for i in range(specimens))
    entries = tuple(
        RecordingEntry(p, s.name, Path(f"{p}_{s.name}"), None, channels, FilterSettings(), WindowSettings())
        for p in people
        for s in things
    )
    defaults: dict[str, Any] = {
        "seed": 3,
        "repetitions": 2,
        "a_v": {s.name: 30e-6 for s in things},
        "b_v": {s.name: (15 - i) * 1e-6 for i, s in enumerate(things)},
    }
    return Study(
        name="small", title="A small study", mode="default", path=Path("study.toml"), participants=people,
        specimens=things, recordings=entries, simulation=SimulationSettings(**defaults | simulation),
        results=Path("results"), reports=Path("reports"), data=Path("data"),
    )  # fmt: skip


@pytest.fixture
def study() -> Study:
    return make_study()


@pytest.fixture
def study_with() -> Callable[..., Study]:
    """``study_with(seed=4)`` is the small study with other simulation settings, participants or specimens."""
    return make_study
