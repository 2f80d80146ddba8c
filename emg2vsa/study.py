"""A study, checked and complete: people, specimens, recordings and the settings of every stage. Plain data."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Literal

from emg2vsa.errors import SettingError
from emg2vsa.session_settings import SessionSettings
from emg2vsa.settings import (
    ChannelSettings,
    FilterSettings,
    PressJudgement,
    RunSettings,
    StageSettings,
    WindowSettings,
)
from emg2vsa.settings_class import settings_class


def registration_of(study_file: Path) -> Path:
    """Where the registration of a study is, unless its file names another: studies of one folder have their own."""
    stem = study_file.stem
    return study_file.with_name("registration.json" if stem == "study" else f"{stem}.registration.json")


_MOST_SHIFT = 0.9
"""Share by which a stiffness may fall beyond the forces it was measured over."""


@dataclass(frozen=True)
class Specimen:
    """A soft specimen; ``stiffness_n_per_mm`` is None where nobody measured it, and comes with its standard error."""

    name: str
    stiffness_n_per_mm: float | None
    stiffness_se_n_per_mm: float = 0.0
    plate_adjusted_r2: float | None = None
    "Worst of its plate indentations."
    stiffness_range_n: tuple[float, float] | None = None
    "Forces over which the stiffness holds."
    stiffness_change: float = 0.0
    "Share by which the stiffness grows over these forces."
    diameter_mm: float | None = None
    height_mm: float | None = None
    "Height of the cylinder between the plates; the height is that under the sensor, too."
    ends: Literal["frictionless", "bonded"] = "frictionless"
    "Whether its ends slide there, or cannot."

    @property
    def size_mm(self) -> tuple[float, float] | None:
        """Diameter and height, mm, where both are known."""
        return (self.diameter_mm, self.height_mm) if self.diameter_mm and self.height_mm else None

    def stiffness_over(self, force_n: tuple[float, float]) -> tuple[float, float]:
        """Stiffness over other forces, N, and its standard error, both N/mm; 95 % reach from no change to twice that of
        its course."""
        assert self.stiffness_n_per_mm is not None
        own, shift = self.stiffness_range_n, 0.0
        if own is not None:
            shift = max(self.stiffness_change * (sum(force_n) - sum(own)) / 2 / (own[1] - own[0]), -_MOST_SHIFT)
        error = math.hypot(self.stiffness_se_n_per_mm * (1 + shift), self.stiffness_n_per_mm * shift / 2)
        return self.stiffness_n_per_mm * (1 + shift), error


@dataclass(frozen=True)
class RecordingPart:
    """One continuous recording: its files and the channels in them.

    force_file : None where force and EMG are in one file. fault : why its files are ambiguous, or "". visit : its
    label, "" where participants come once.
    """

    emg_file: Path
    force_file: Path | None
    channels: ChannelSettings
    fault: str = ""
    visit: str = ""


@dataclass(frozen=True)
class RecordingEntry:
    """What one participant pressed on one specimen, with the settings that hold for it: mostly one recording.

    further : recordings whose presses follow those of the first, in this order. visit : of the first.
    """

    participant: str
    specimen: str
    emg_file: Path
    force_file: Path | None
    channels: ChannelSettings
    filters: FilterSettings
    window: WindowSettings
    fault: str = ""
    further: tuple[RecordingPart, ...] = ()
    mvc_files: tuple[Path, ...] = ()
    "Recordings of the participant's maximum voluntary contractions."
    visit: str = ""

    @property
    def key(self) -> str:
        return f"{self.participant}/{self.specimen}"

    @cached_property
    def parts(self) -> tuple[RecordingPart, ...]:
        """All recordings of it, in the order of their presses."""
        return (RecordingPart(self.emg_file, self.force_file, self.channels, self.fault, self.visit), *self.further)

    @property
    def wanted_presses(self) -> int | None:
        """Presses wanted at all its visits; None where the study does not say."""
        of_visit = self.window.expected_trials
        return of_visit and of_visit * len({part.visit for part in self.parts})

    @property
    def files(self) -> tuple[Path, ...]:
        """Every file of it."""
        return tuple(path for part in self.parts for path in (part.emg_file, part.force_file) if path is not None)


@dataclass(frozen=True)
class Person:
    """What participants.tsv says of a participant, as it is written there; "" where nothing is said."""

    participant: str
    age: str = ""
    sex: str = ""
    handedness: str = ""


@dataclass(frozen=True)
class RunEntry:
    """A specimen pressed at an angle under a condition; ``folders`` of an emulated run are yet to be made.

    order : place of each folder in the order in which all were recorded, where a table of runs says it; else empty.
    """

    specimen: str
    angle_deg: float
    condition: str
    folders: tuple[Path, ...]
    order: tuple[float, ...] = ()

    @property
    def key(self) -> str:
        return f"{self.specimen}_{self.angle_deg:g}_{self.condition}"


@dataclass(frozen=True)
class RunsSource:
    """Where the runs of a study come from. ``rig``: the rig file whose emulated rig makes them; None: measured runs.

    root : folder of the runs. camera : camera file of measured runs that have none of their own. domes : folder of the
    sensor's own tables of domes. plates : folder of
    plate indentations, which stays where it is when emulated runs are made elsewhere.
    """

    root: Path
    rig: Path | None
    camera: Path | None
    plates: Path
    domes: Path | None = None


def plates_beside(runs: Path) -> Path:
    """The folder of plate indentations that belongs to the folder ``runs``."""
    return runs.with_name(f"{runs.name}-plate")


@settings_class
class Study(StageSettings):
    """A whole study, with the settings of every stage. ``path``: its study file."""

    name: str
    title: str
    mode: str
    path: Path
    participants: tuple[str, ...]
    specimens: tuple[Specimen, ...]
    recordings: tuple[RecordingEntry, ...]
    results: Path
    reports: Path
    data: Path
    "Folder of the recordings; a simulation writes there."
    judgements: tuple[PressJudgement, ...] = ()
    "What people said of presses; a later one has the last word."
    people: tuple[Person, ...] = ()
    "What is known of the participants, in their order; empty where they have no table."
    scoring: RunSettings = field(default_factory=RunSettings)
    "How the rig's presses are scored."
    runs_source: RunsSource | None = None
    "Where the rig's runs come from; None: the study has none."
    runs: tuple[RunEntry, ...] = ()
    "The rig's runs, once they have been looked up."
    session: SessionSettings | None = None
    "How a participant's session is run; None: the study file does not say."
    registration: Path | None = None
    "The registration that the study is compared with; None: it is not registered."
    task: str = ""
    "BIDS label of the task; a layout that is not BIDS has none."
    visits: tuple[str, ...] = ()
    "Labels of the visits of each participant, in order; empty where each comes once."
    visit: str = ""
    "The visit that a session is of; see `at_visit`."

    def at_visit(self, visit: str | None) -> Study:
        """The study for a session at one of its visits. SettingError for none of them, or one too many."""
        if visit is None and not self.visits:
            return self
        if visit in self.visits:
            return replace(self, visit=visit)
        wanted = f"one of {', '.join(self.visits)}" if self.visits else "no visit, for participants come once"
        do = "Choose one of them." if self.visits else f'Add visits = ["1", "2"] to [recordings] of {self.path}.'
        raise SettingError(f"--visit {visit or ''}".strip(), wanted=wanted, found=visit or "none", do=do)

    def __repr__(self) -> str:
        counts = (
            f"{len(self.participants)} participants, {len(self.specimens)} specimens, {len(self.recordings)} recordings"
        )
        return f"Study({self.name!r}, {self.mode} mode: {counts})"

    @property
    def palpated(self) -> tuple[str, ...]:
        """Specimens that every participant was asked to press: those of the recordings, lost ones included."""
        asked = {recording.specimen for recording in self.recordings}
        return tuple(specimen.name for specimen in self.specimens if specimen.name in asked)

    @property
    def stiffness_n_per_mm(self) -> dict[str, float]:
        """Specimen name to stiffness, N/mm, for the specimens whose stiffness is known."""
        return {s.name: s.stiffness_n_per_mm for s in self.specimens if s.stiffness_n_per_mm is not None}

    @property
    def pressed_n_per_mm(self) -> dict[str, float]:
        """Name to stiffness, N/mm, of whatever the rig may press: the new specimen as well."""
        new, stiffness = self.profile.new_specimen, self.profile.new_stiffness_n_per_mm
        return self.stiffness_n_per_mm | ({new: stiffness} if new and stiffness else {})

    @property
    def heights_mm(self) -> dict[str, float | None]:
        """Specimen name to its height, mm, of the new specimen as well; None where it is not known."""
        new = {self.profile.new_specimen: self.profile.new_height_mm} if self.profile.new_specimen else {}
        return {each.name: each.height_mm for each in self.specimens} | new

    @property
    def kappa_of_scores(self) -> tuple[dict[str, float], dict[str, float]]:
        """Stiffness of whatever the rig may press over the forces of its spread rates, and its standard errors."""
        known = {
            s.name: s.stiffness_over(self.scoring.force_n) for s in self.specimens if s.stiffness_n_per_mm is not None
        }
        kappa = self.pressed_n_per_mm | {name: over for name, (over, _) in known.items()}
        return kappa, {name: error for name, (_, error) in known.items()}
