"""A study, checked and complete: people, specimens, recordings and the settings of every stage. Plain data."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from emg2vsa.settings import (
    ChannelSettings,
    CocontractionSettings,
    FilterSettings,
    FitSettings,
    HypothesisSettings,
    ProfileSettings,
    ScheduleSettings,
    SimulationSettings,
    WindowSettings,
)


@dataclass(frozen=True)
class Specimen:
    """A soft specimen; ``stiffness_n_per_mm`` is None where nobody measured it."""

    name: str
    stiffness_n_per_mm: float | None


@dataclass(frozen=True)
class RecordingEntry:
    """One continuous recording of one participant on one specimen, with the settings that hold for it."""

    participant: str
    specimen: str
    emg_file: Path
    force_file: Path | None
    channels: ChannelSettings
    filters: FilterSettings
    window: WindowSettings

    @property
    def key(self) -> str:
        return f"{self.participant}/{self.specimen}"


@dataclass(frozen=True)
class Study:
    """A whole study. ``path`` is its study file; ``results`` and ``reports`` are where outcomes go."""

    name: str
    title: str
    mode: str
    path: Path
    participants: tuple[str, ...]
    specimens: tuple[Specimen, ...]
    recordings: tuple[RecordingEntry, ...]
    cocontraction: CocontractionSettings
    fit: FitSettings
    hypotheses: HypothesisSettings
    profile: ProfileSettings
    schedule: ScheduleSettings
    simulation: SimulationSettings | None
    results: Path
    reports: Path
    data: Path
    "Folder of the recordings; a simulation writes there."
    window: WindowSettings
    "The study's force window; all recordings share its forces, and may differ in the rest."

    @property
    def stiffness_n_per_mm(self) -> dict[str, float]:
        """Specimen name to stiffness, for the specimens whose stiffness is known."""
        return {s.name: s.stiffness_n_per_mm for s in self.specimens if s.stiffness_n_per_mm is not None}
