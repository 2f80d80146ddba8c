"""A recording as BIDS-EMG: BDF+, its channels, how it was made, and what happened in it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

from casr.atomic import write_bytes_atomic
from emg2vsa.bids.bdf import bdf_bytes
from emg2vsa.bids.channels import COLUMNS, Channel, muscle_name
from emg2vsa.bids.events import Event, EventColumns, Screen
from emg2vsa.bids.names import CHANNELS, EVENTS, EVENTS_SIDECAR, SIDECAR, RecordingName, beside
from emg2vsa.bids.tables import ABSENT, Json, write_json, write_tsv

_KEYS = {
    "ground": "EMGGround", "placement": "EMGPlacementSchemeDescription", "model": "ManufacturersModelName",
    "electrodes": "ElectrodeManufacturersModelName", "institution": "InstitutionName", "serial": "DeviceSerialNumber",
}  # fmt: skip
"""Terms whose key is not the term itself in the standard's spelling."""
_FROM_SOURCE = (
    "Manufacturer", "ManufacturersModelName", "DeviceSerialNumber", "HardwareFilters", "SoftwareFilters",
    "EMGReference", "EMGGround", "EMGPlacementScheme", "EMGPlacementSchemeDescription", "PowerLineFrequency",
    "InterelectrodeDistance", "ElectrodeManufacturer", "ElectrodeManufacturersModelName", "ElectrodeType",
    "ElectrodeMaterial", "InstitutionName", "InstitutionAddress", "InstitutionalDepartmentName", "Instructions",
    "SkinPreparation",
)  # fmt: skip
_ORDER = (
    "TaskName", "TaskDescription", "Instructions", "SamplingFrequency", "PowerLineFrequency", "RecordingType",
    "RecordingDuration", "EpochLength", "SoftwareFilters", "HardwareFilters", "EMGReference", "EMGGround",
    "EMGPlacementScheme", "EMGPlacementSchemeDescription", "EMGChannelCount", "MiscChannelCount", "TriggerChannelCount",
    "InterelectrodeDistance", "ElectrodeMaterial", "ElectrodeType", "ElectrodeManufacturer",
    "ElectrodeManufacturersModelName", "Manufacturer", "ManufacturersModelName", "AmplifierType", "DeviceSerialNumber",
    "SoftwareVersions", "SubjectArtefactDescription", "InstitutionName", "InstitutionAddress",
    "InstitutionalDepartmentName",
)  # fmt: skip
"""Keys of a side file that states them all, in their order; any other begins with what this program knows."""


@dataclass(frozen=True)
class Recording:
    """One data file and what stands beside it. Its presses are those of one finger on a soft specimen.

    fs_hz : of the EMG, as stated. duration_s : without what fills the last data record, of ``record_s``. equipment,
    software : what wrote the file. events : None where there is no table of them. screen : what showed the commands,
    where that is told of each recording.

    how : what is known of devices, electrodes and place, by terms such as skin_preparation, ground, electrodes (their
    model), placement, institution, model and serial (of the device). further : keys as they stand.
    """

    name: RecordingName
    channels: Sequence[Channel]
    fs_hz: float
    duration_s: float
    record_s: float
    equipment: str
    software: str
    events: Sequence[Event] | None
    columns: EventColumns
    screen: Screen | None = None
    started: datetime | None = None
    mains_hz: float | None = None
    electrode_mm: float | None = None
    how: Mapping[str, object] = field(default_factory=dict)
    further: Mapping[str, object] = field(default_factory=dict)

    def sidecar(self) -> Json:
        muscles = [muscle_name(channel.muscle) for channel in self.channels if channel.muscle]
        placed = f"Bipolar electrodes over the bellies of: {', '.join(muscles)}." if muscles else "No EMG in this file."
        stated = {
            "TaskName": self.name.task,
            "TaskDescription": "Press a soft specimen with one finger, several times, with rests between.",
            "SamplingFrequency": self.fs_hz,
            "PowerLineFrequency": ABSENT if self.mains_hz is None else self.mains_hz,
            "RecordingType": "continuous",
            "RecordingDuration": round(self.duration_s, 6),
            "SoftwareFilters": ABSENT,
            "EMGReference": "bipolar",
            "EMGPlacementScheme": "Other",
            "EMGPlacementSchemeDescription": placed,
            "EMGChannelCount": len(muscles),
            "MiscChannelCount": len(self.channels) - len(muscles),
            "TriggerChannelCount": 0,
            **({} if self.electrode_mm is None else {"InterelectrodeDistance": self.electrode_mm}),
            "SoftwareVersions": self.software,
            **{_KEYS.get(term, _spelt(term)): told for term, told in self.how.items()},
            **self.further,
        }
        order = _ORDER if stated.keys() >= set(_ORDER) else ()
        return {key: stated[key] for key in dict.fromkeys((*order, *stated))}


def write_recording(root: Path, recording: Recording) -> Path:
    """The files of a recording in the data set ``root``; returns the data file, which comes last.

    SettingError : BDF cannot hold the name of a channel.
    """
    path, events = recording.name.path(root), recording.events
    content = bdf_bytes(
        recording.channels, events or (), patient=recording.name.participant, equipment=recording.equipment,
        record_s=recording.record_s, started=recording.started,
    )  # fmt: skip
    write_json(beside(path, SIDECAR), recording.sidecar())
    write_tsv(beside(path, CHANNELS), COLUMNS, [channel.cells() for channel in recording.channels])
    if events is not None:
        write_tsv(beside(path, EVENTS), recording.columns.names, recording.columns.rows(events))
    if recording.screen is not None:
        write_json(beside(path, EVENTS_SIDECAR), recording.columns.json() | recording.screen.json())
    write_bytes_atomic(path, content)  # who waits for it finds what belongs to it
    return path


def of_source(stated: Mapping[str, object]) -> Json:
    """Of the side file of another data set: what it says of how the recording was made."""
    return {key: stated[key] for key in _FROM_SOURCE if key in stated}


def _spelt(term: str) -> str:
    return "".join(part[:1].upper() + part[1:] for part in re.split(r"[^A-Za-z0-9]+", term))
