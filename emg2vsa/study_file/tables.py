"""The tables of a study file, as dataclasses; the stages' own tables are the classes of ``emg2vsa.settings``."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Annotated, Literal, TypeVar

from emg2vsa.session_settings import SessionSettings
from emg2vsa.settings import (
    ChannelSettings,
    EmgChannelSettings,
    FilterSettings,
    ForceChannelSettings,
    Ge,
    Gt,
    Le,
    MinLen,
    NonNegative,
    Positive,
    RunSettings,
    StageSettings,
    WindowSettings,
)
from emg2vsa.settings_class import settings_class
from emg2vsa.study_file.problems import Pattern

_WANTED = "letters, digits, - _ and dots only, the first a letter or digit"
Name = Annotated[str, Pattern(r"[A-Za-z0-9][A-Za-z0-9_.-]*", _WANTED)]
"""Names become parts of file names: ASCII letters, digits, and - _ . after the first."""
Text = Annotated[str, MinLen(1)]
MOST_CHANGE = 5
"""Largest change of a stiffness over its range of force, as a share. A stiffness that changes by more is not one
number.
"""


@settings_class
class StudyTable:
    """What the study is called, and where its outcomes go. Paths are relative to the folder of the study file."""

    name: Name
    "Short name: letters, digits, - _ and dots."
    title: str = ""
    "Title of the report; omitted: the name."
    mode: Literal["default", "paper"] = "default"
    "default: what a careful analyst would do; paper: what the paper did, for every key the study does not set itself."
    results: Text | None = None
    "Folder of the intermediate results; omitted: .emg2vsa/<name>."
    reports: Text | None = None
    "Folder of the report; omitted: reports/<name>, or ../../reports/<name> where the file lies in studies/<folder>."
    registration: Text | None = None
    "Registration that the study is compared with (emg2vsa register); omitted: registration.json beside it, if there."


@settings_class
class ParticipantsTable:
    """Who took part: either ``ids`` or ``file``."""

    ids: Annotated[tuple[Name, ...], MinLen(1)] | None = None
    "Participant ids."
    file: Text | None = None
    "Tab-separated table with a participant_id column, as in BIDS; age, sex and handedness go into the methods text."


@settings_class
class SpecimenTable:
    """A soft specimen."""

    name: Name
    "Short name: letters, digits, - _ and dots."
    stiffness_n_per_mm: Positive | None = None
    "Stiffness by plate indentation, N/mm; omitted: not measured."
    stiffness_se_n_per_mm: NonNegative = 0.0
    "Its standard error, which the interval of a calibrated stiffness counts in (emg2vsa tools stiffness)."
    stiffness_range_n: tuple[Positive, Positive] | None = None
    "Forces over which it is that stiffness, newtons; omitted: not known (emg2vsa tools stiffness)."
    stiffness_change: Annotated[float, Gt(-1), Le(MOST_CHANGE)] = 0.0
    """Share by which the stiffness grows from the first of these forces to the second; with it a calibration takes
    the stiffness over the forces of its spread rates (emg2vsa tools stiffness)."""
    plate_adjusted_r2: Annotated[float, Le(1)] | None = None
    "Worst adjusted R2 of its plate indentations, for the report (emg2vsa tools stiffness)."
    diameter_mm: Positive | None = None
    "Diameter of a cylinder that plates press, mm; with its height its modulus can be told (emg2vsa tools stiffness)."
    height_mm: Positive | None = None
    "Its height, mm; with [runs] domes also the thickness that tables of domes are taken for."
    ends: Literal["frictionless", "bonded"] = "frictionless"
    "Whether the ends of the cylinder slide between the plates, as lubricated ones do, or cannot."


@settings_class
class FileChannels:
    """The channels of one recording, where they are not the study's."""

    emg: Annotated[dict[str, EmgChannelSettings], MinLen(1)] | None = None
    "Muscle role to channel; replaces all of the study's [channels.emg]."
    force: ForceChannelSettings | None = None
    "The pressing force; replaces the study's [channels.force]."


@settings_class
class FileTable:
    """One recording: named here, or found by the layout and only changed here.

    Presses of a further recording of the same participant on the same specimen follow those of the one before it.
    """

    participant: Name
    "Participant id."
    specimen: Name
    "Specimen name."
    emg: Text | None = None
    "File of the EMG; omitted: where the layout says."
    force: Text | None = None
    "File of the force, on the same clock; omitted: where the layout says, else the EMG file."
    channels: FileChannels | None = None
    "Channels of this recording."
    filters: FilterSettings | None = None
    "Keys that replace the study's [filters] for this recording; the others keep."
    window: WindowSettings | None = None
    "Keys that replace the study's [window] for this recording, all but force_n; the others keep."


@settings_class
class RecordingsTable:
    """Where the recordings are. Paths are relative to the folder of the study file."""

    layout: Literal["bids", "pattern", "files"]
    "bids: a BIDS-EMG folder, one acq- label per specimen; pattern: a path with placeholders; files: listed one by one."
    root: Text | None = None
    "bids: the dataset's folder."
    task: Text | None = None
    "bids: the task label."
    extension: Literal["bdf", "edf"] = "bdf"
    "bids: format of the recordings."
    visits: tuple[Text, ...] = ()
    """bids: ses- labels of the visits of each participant, in order; omitted: each comes once. All visits of a person
    count as one person."""
    pattern: Text | None = None
    "pattern: path of the EMG file with {participant}, {specimen} and, for several of them, {repetition}; *: any text."
    force_pattern: Text | None = None
    "pattern: path of the force file, where force sits in a file of its own; {repetition} as in pattern."
    files: tuple[FileTable, ...] = ()
    "Recordings named one by one, and exceptions from the layout."


@settings_class
class RunsTable(RunSettings):
    """The rig's runs, and how their presses are scored. Paths are relative to the folder of the study file."""

    root: Text | None = None
    "Folder of the runs. Omitted: runs, for measured ones; with a rig runs-virtual, apart from those of a real rig."
    rig: Text | None = None
    "Rig file whose emulated rig makes the runs; omitted: the runs in root were measured."
    camera: Text | None = None
    "Camera file (camera.toml) of measured runs that have none of their own; without one areas are in pixels."
    domes: Text | None = None
    """Folder of tables of the sensor's own dome (casr dome), beside those that come with casr. With it presses on a
    specimen of known height_mm are scored by tables of that height, or between two of them."""


@settings_class
class JudgementTable:
    """A person's word on a press, for [[exclude]] and [[accept]]; it is told wherever the press is."""

    participant: Name
    "Participant id."
    specimen: Name
    "Specimen name."
    repetition: Annotated[int, Ge(1)] | None = None
    "Number of the press, from 1 in time order; omitted: every press of the recording."
    reason: Text
    "Why, in a few words."


@settings_class
class MvcTable:
    """A recording of maximum voluntary contractions, for normalise = "mvc"."""

    participant: Name
    "Participant id."
    emg: Text
    "File with the EMG channels of the study; of several of one participant the largest level of a muscle counts."


@settings_class
class Recorded:
    """Who pressed what, and what was recorded of it."""

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
    mvc: tuple[MvcTable, ...] = ()
    "Recordings of maximum voluntary contractions; a muscle's level replaces that of cocontraction.mvc_v."
    exclude: tuple[JudgementTable, ...] = ()
    "Presses that a person rejects."
    accept: tuple[JudgementTable, ...] = ()
    "Presses that a person takes as ok; one without a fit stays rejected, and a fault needs the whole recording."


@settings_class
class StudyFile(StageSettings, Recorded):
    """A whole study file."""

    runs: RunsTable | None = None
    "The rig's runs; omitted: the study ends with the schedules."
    session: SessionSettings | None = None
    "How a participant's session is run; omitted: recordings were made by other means."


Settings = TypeVar("Settings", FilterSettings, WindowSettings)


def overlaid(table: Settings, own: Settings, given: Iterable[str]) -> Settings:
    """The study's ``table`` with those keys of a recording's ``own`` that it sets itself."""
    return replace(table, **{key: getattr(own, key) for key in given})
