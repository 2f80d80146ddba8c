"""What is told of a recording, and how BIDS-EMG says it: channels, events, and how it was made."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from emg2vsa.bids.names import RecordingName
from emg2vsa.bids.tables import ABSENT, Column, Json

CHANNEL_COLUMNS = (
    "name", "type", "units", "description", "sampling_frequency", "signal_electrode", "reference", "group",
    "target_muscle", "placement_scheme", "placement_description", "interelectrode_distance", "low_cutoff",
    "high_cutoff", "notch", "status", "status_description",
)  # fmt: skip
_MUSCLES = {
    "EDC": "extensor digitorum communis", "FDS": "flexor digitorum superficialis", "FCR": "flexor carpi radialis",
    "FCU": "flexor carpi ulnaris", "ECR": "extensor carpi radialis", "ECU": "extensor carpi ulnaris",
    "FDP": "flexor digitorum profundus",
}  # fmt: skip
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


def muscle_name(role: str) -> str:
    """Name of a muscle by the role that it mostly has in a study file; the role where it is none of these."""
    return _MUSCLES.get(role.upper(), role)


@dataclass(frozen=True)
class Channel:
    """samples : (n,) finite, in ``unit``, "" where it has none. muscle : its role in the study, None for the force.

    said : what else is to be said of it, behind a mark. told : what is to be known of its samples. stated_hz : the rate
    as the table has it, "" : to ten digits. pair : name of the electrodes, "" : as the channel. placed : what is to be
    said of their place. band_hz : of the amplifier, None where it is not known.
    """

    label: str
    samples: NDArray[np.float64]
    unit: str
    fs_hz: float
    muscle: str | None
    said: str = ""
    told: str = ""
    stated_hz: str = ""
    pair: str = ""
    placed: str = ""
    band_hz: tuple[float, float] | None = None

    @property
    def pair_name(self) -> str:
        """Name of the electrodes, which end in 1 and 2."""
        return self.pair or self.label

    def cells(self, electrode_mm: float | None) -> tuple[object, ...]:
        """Cells of a row in the order of ``CHANNEL_COLUMNS``. electrode_mm : distance of the two, mm; None where it is
        not known.
        """
        said = (f"surface EMG of {self.muscle}" if self.muscle else "pressing force") + self.said
        rate, unit = self.stated_hz or f"{self.fs_hz:.10g}", self.unit or ABSENT
        tail = (ABSENT, "good", self.told or ABSENT)
        if self.muscle is None:
            return (self.label, "MISC", unit, said, rate, *[ABSENT] * 9, *tail)
        pair, name = self.pair_name, muscle_name(self.muscle)
        distance = ABSENT if electrode_mm is None else f"{electrode_mm:g}"
        where = ("other", f"belly of the {name}{self.placed}", distance, *(self.band_hz or (ABSENT, ABSENT)))
        return (self.label, "EMG", unit, said, rate, f"{pair}1", f"{pair}2", pair, name, *where, *tail)


@dataclass(frozen=True)
class Event:
    """onset_s, duration_s : from the first sample, rounded as they are to be written; None for what has no length.

    cells : by name of the column; one that is left out is not applicable.
    """

    onset_s: float
    duration_s: float | None
    kind: str
    cells: Mapping[str, object] = field(default_factory=dict)


def event_columns(
    onset: str, duration: str, kind: Column, own: Mapping[str, Column] | None = None
) -> dict[str, Column]:
    """Columns of a table of events. onset, duration : what is said of these times. own : beyond time and kind."""
    return {"onset": Column(onset, "s"), "duration": Column(duration, "s"), "trial_type": kind, **(own or {})}


def told_of_screen(**terms: object) -> Json:
    """What told the participant what to do, as it stands beside the columns of events; the program is this one."""
    return {"StimulusPresentation": {"SoftwareName": "emg2vsa"} | {_spelt(term): told for term, told in terms.items()}}


@dataclass(frozen=True)
class Recording:
    """One data file and what stands beside it. Its presses are those of one finger on a soft specimen.

    fs_hz : of the EMG, as stated. duration_s : without what fills the last data record, of ``record_s``. equipment,
    software : what wrote the file. events : None where there is no table of them; decimals : of their times, None: as
    needed. screen : `told_of_screen`, where that is told of each recording. electrode_mm : distance of those of a pair.

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
    columns: Mapping[str, Column]
    decimals: int | None = None
    screen: Json | None = None
    started: datetime | None = None
    mains_hz: float | None = None
    electrode_mm: float | None = None
    how: Mapping[str, object] = field(default_factory=dict)
    further: Mapping[str, object] = field(default_factory=dict)

    def sidecar(self) -> Json:
        """The ``_emg.json``."""
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

    def event_rows(self) -> list[list[object]]:
        """Cells of the events, in the order of ``columns``."""

        def at(time_s: float | None) -> object:
            return ABSENT if time_s is None else time_s if self.decimals is None else f"{time_s:.{self.decimals}f}"

        rows = [
            {"onset": at(event.onset_s), "duration": at(event.duration_s), "trial_type": event.kind, **event.cells}
            for event in self.events or ()
        ]
        return [[row.get(name, ABSENT) for name in self.columns] for row in rows]


def of_source(stated: Mapping[str, object]) -> Json:
    """What the side file of another data set says of how the recording was made."""
    return {key: stated[key] for key in _FROM_SOURCE if key in stated}


def _spelt(term: str) -> str:
    return "".join(part[:1].upper() + part[1:] for part in re.split(r"[^A-Za-z0-9]+", term))
