"""The tables of a study file, as dataclasses; the stages' own tables are the classes of ``emg2vsa.settings``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Literal

from annotated_types import MinLen
from pydantic import Field

from emg2vsa.settings import (
    FORBID_UNKNOWN_KEYS,
    CalibrationSettings,
    ChannelSettings,
    CocontractionSettings,
    DiscriminationSettings,
    EmgChannelSettings,
    FilterSettings,
    FitSettings,
    ForceChannelSettings,
    HypothesisSettings,
    NonNegative,
    Positive,
    ProfileSettings,
    RunSettings,
    ScheduleSettings,
    SimulationSettings,
    WindowSettings,
)

Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$")]
"""Names become parts of file names: ASCII letters, digits, and - _ . after the first."""
Text = Annotated[str, MinLen(1)]


@dataclass(frozen=True, kw_only=True)
class StudyTable:
    """What the study is called, and where its outcomes go. Paths are relative to the folder of the study file."""

    __pydantic_config__ = FORBID_UNKNOWN_KEYS

    name: Name
    "Short name: letters, digits, - _ and dots."
    title: str = ""
    "Title of the report; omitted: the name."
    mode: Literal["default", "paper"] = "default"
    "default: what a careful analyst would do; paper: what the paper did, for every key the study does not set itself."
    results: Text | None = None
    "Folder of the intermediate results; omitted: .emg2vsa/<name>."
    reports: Text | None = None
    "Folder of the report; omitted: ../../reports/<name>."


@dataclass(frozen=True, kw_only=True)
class ParticipantsTable:
    """Who took part: either ``ids`` or ``file``."""

    __pydantic_config__ = FORBID_UNKNOWN_KEYS

    ids: Annotated[tuple[Name, ...], MinLen(1)] | None = None
    "Participant ids."
    file: Text | None = None
    "Tab-separated table with a participant_id column, as in BIDS; a leading 'sub-' is dropped."


@dataclass(frozen=True, kw_only=True)
class SpecimenTable:
    """A soft specimen."""

    __pydantic_config__ = FORBID_UNKNOWN_KEYS

    name: Name
    "Short name: letters, digits, - _ and dots."
    stiffness_n_per_mm: Positive | None = None
    "Stiffness by plate indentation, N/mm; omitted: not measured."
    stiffness_se_n_per_mm: NonNegative = 0.0
    "Its standard error, which the interval of a calibrated stiffness counts in (emg2vsa stiffness)."


@dataclass(frozen=True, kw_only=True)
class FileChannels:
    """The channels of one recording, where they are not the study's."""

    __pydantic_config__ = FORBID_UNKNOWN_KEYS

    emg: Annotated[dict[str, EmgChannelSettings], MinLen(1)] | None = None
    "Muscle role to channel; replaces all of the study's [channels.emg]."
    force: ForceChannelSettings | None = None
    "The pressing force; replaces the study's [channels.force]."


@dataclass(frozen=True, kw_only=True)
class FileTable:
    """One recording: named here, or found by the layout and only changed here."""

    __pydantic_config__ = FORBID_UNKNOWN_KEYS

    participant: Name
    "Participant id."
    specimen: Name
    "Specimen name."
    emg: Text | None = None
    "File of the EMG; omitted: where the layout says."
    force: Text | None = None
    "File of the force, on the same clock; omitted: where the layout says, else the EMG file."
    channels: FileChannels = field(default_factory=FileChannels)
    "Channels of this recording."
    filters: FilterSettings = field(default_factory=FilterSettings)
    "Keys that replace the study's [filters] for this recording; the others keep."
    window: WindowSettings = field(default_factory=WindowSettings)
    "Keys that replace the study's [window] for this recording, all but force_n; the others keep."


@dataclass(frozen=True, kw_only=True)
class RecordingsTable:
    """Where the recordings are. Paths are relative to the folder of the study file."""

    __pydantic_config__ = FORBID_UNKNOWN_KEYS

    layout: Literal["bids", "pattern", "files"]
    "bids: a BIDS-EMG folder, one acq- label per specimen; pattern: a path with placeholders; files: listed one by one."
    root: Text | None = None
    "bids: the dataset's folder."
    task: Text | None = None
    "bids: the task label."
    extension: Literal["bdf", "edf"] = "bdf"
    "bids: format of the recordings."
    pattern: Text | None = None
    "pattern: path of the EMG file with {participant} and {specimen} in it."
    force_pattern: Text | None = None
    "pattern: path of the force file, where force sits in a file of its own."
    files: tuple[FileTable, ...] = ()
    "Recordings named one by one, and exceptions from the layout."


@dataclass(frozen=True, kw_only=True)
class RunsTable(RunSettings):
    """The rig's runs, and how their presses are scored. Paths are relative to the folder of the study file."""

    root: Text = "runs"
    "Folder of the runs: an emulated rig writes there, measured runs lie there."
    rig: Text | None = None
    "Rig file whose emulated rig makes the runs; omitted: the runs in root were measured."
    camera: Text | None = None
    "Camera file (camera.toml) of measured runs that have none of their own; without one areas are in pixels."


@dataclass(frozen=True, kw_only=True)
class StudyFile:
    """A whole study file."""

    __pydantic_config__ = FORBID_UNKNOWN_KEYS

    study: StudyTable
    "Name, title, mode and folders."
    participants: ParticipantsTable | None = None
    "Who took part; a study of measured runs alone has neither this nor recordings."
    specimens: Annotated[tuple[SpecimenTable, ...], MinLen(1)]
    "The soft specimens."
    recordings: RecordingsTable | None = None
    "Where the recordings are; a study of measured runs alone has none."
    channels: ChannelSettings | None = None
    "Which channel plays which role; may be omitted where every recording has its own."
    filters: FilterSettings = field(default_factory=FilterSettings)
    "Conditioning of EMG and force."
    cocontraction: CocontractionSettings = field(default_factory=CocontractionSettings)
    "How muscles become one activity."
    window: WindowSettings = field(default_factory=WindowSettings)
    "What is a trial, and which trials are good."
    fit: FitSettings = field(default_factory=FitSettings)
    "The logarithmic fit."
    hypotheses: HypothesisSettings = field(default_factory=HypothesisSettings)
    "The tests on its slope."
    profile: ProfileSettings = field(default_factory=ProfileSettings)
    "Mean trends and the new specimen."
    schedule: ScheduleSettings = field(default_factory=ScheduleSettings)
    "From co-contraction to actuator stiffness."
    runs: RunsTable | None = None
    "The rig's runs; omitted: the study ends with the schedules."
    discrimination: DiscriminationSettings = field(default_factory=DiscriminationSettings)
    "The tests on contact areas and spread rates."
    calibration: CalibrationSettings = field(default_factory=CalibrationSettings)
    "From spread rate to stiffness."
    simulation: SimulationSettings | None = None
    "The synthetic study; omitted: the study cannot be simulated."
