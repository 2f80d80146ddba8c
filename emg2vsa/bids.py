"""BIDS-EMG (1.11.1) as files: channels as BDF+, tables and JSON beside them, for simulated and for own recordings."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
from edfio import Bdf, BdfSignal, EdfAnnotation, Patient, Recording
from numpy.typing import NDArray

from casr.atomic import write_text_atomic
from emg2vsa import __version__
from emg2vsa.errors import SettingError
from emg2vsa.settings import LABEL_CHARACTERS

BIDS_VERSION = "1.11.1"
Json = dict[str, Any]
CHANNEL_COLUMNS = (
    "name", "type", "units", "description", "sampling_frequency", "signal_electrode", "reference", "group",
    "target_muscle", "placement_scheme", "placement_description", "interelectrode_distance", "low_cutoff",
    "high_cutoff", "notch", "status", "status_description",
)  # fmt: skip
MUSCLES = {
    "EDC": "extensor digitorum communis", "FDS": "flexor digitorum superficialis", "FCR": "flexor carpi radialis",
    "FCU": "flexor carpi ulnaris", "ECR": "extensor carpi radialis", "ECU": "extensor carpi ulnaris",
    "FDP": "flexor digitorum profundus",
}  # fmt: skip
"""Names of muscles by the roles they mostly have in a study file."""
_RATE_TOLERANCE = 1e-6
_LONGEST_RECORD_S = 2.0


@dataclass(frozen=True)
class BdfChannel:
    """samples : (n,) finite, in ``unit``. transducer : the kind of sensor."""

    name: str
    samples: NDArray[np.float64]
    unit: str
    fs_hz: float
    transducer: str


def bdf_bytes(
    channels: Sequence[BdfChannel],
    annotations: Iterable[tuple[float, float | None, str]],
    *,
    patient: str,
    equipment: str,
    record_s: float,
    started: datetime | None = None,
) -> bytes:
    """Channels as BDF+ (24-bit European data format), with (onset s, duration s, text) as annotations.

    Each channel has its own symmetric range, so a stored value is exact to 6e-8 of that range. Samples fill whole data
    records of ``record_s``. SettingError for a name that BDF cannot hold.
    """
    file = Bdf(
        [_signal(channel) for channel in channels],
        patient=Patient(code=patient),
        recording=Recording(startdate=started.date() if started else None, equipment_code=equipment),
        starttime=started.time() if started else None,
        data_record_duration=record_s,
        annotations=[EdfAnnotation(*annotation) for annotation in annotations],
    )
    return file.to_bytes()


def record_s(rates_hz: Iterable[float]) -> float | None:
    """The shortest length of a data record, s, that holds whole samples at each of the rates; None where none does.

    A rate may move by a millionth, and the length is one that the format's eight characters can write.
    """
    rates = sorted(set(rates_hz))
    if all(rate.is_integer() for rate in rates):
        return 1.0
    slowest = rates[0]
    for n in range(1, math.floor(_LONGEST_RECORD_S * slowest) + 1):
        length = float(f"{n / slowest:.6f}")
        counts = [rate * length for rate in rates]
        if length > 0 and all(abs(c - round(c)) <= _RATE_TOLERANCE * c and round(c) > 0 for c in counts):
            return length
    return None


def _signal(channel: BdfChannel) -> BdfSignal:
    if len(channel.name) > LABEL_CHARACTERS or not channel.name.isascii():
        raise SettingError(
            f"channel {channel.name!r}",
            wanted=f"a name of at most {LABEL_CHARACTERS} ASCII characters, for BDF holds no more",
            found=f"{len(channel.name)} characters",
            do="Shorten it, or write another format.",
        )
    limit = _two_digits_above(float(np.max(np.abs(channel.samples))))
    return BdfSignal(
        channel.samples,
        channel.fs_hz,
        label=channel.name,
        transducer_type=channel.transducer,
        physical_dimension=channel.unit,
        physical_range=(-limit, limit),
    )


def _two_digits_above(value: float) -> float:
    """``value`` rounded up to two significant digits, which fit the eight characters a range may take; 1 for zero."""
    if value == 0:
        return 1.0
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    limit = math.ceil(value / unit) * unit
    return float(f"{limit:.2g}")


def channel_cells(
    label: str, muscle: str | None, unit: str, said: str, fs_hz: float, *, electrode_mm: float | None, told: str = ""
) -> tuple[object, ...]:
    """Cells of a channel in the order of ``CHANNEL_COLUMNS``. muscle : its role; None for the force.

    said : what the channel is. told : what is to be known of its samples.
    """
    head = (label, "EMG" if muscle else "MISC", unit, said, f"{fs_hz:.10g}")
    tail = ("n/a", "good", told or "n/a")
    if muscle is None:
        return (*head, *["n/a"] * 9, *tail)
    name = MUSCLES.get(muscle.upper(), muscle)
    distance = "n/a" if electrode_mm is None else f"{electrode_mm:g}"
    placed = ("other", f"belly of the {name}", distance, "n/a", "n/a")
    return (*head, f"{label}1", f"{label}2", label, name, *placed, *tail)


def emg_sidecar(
    task: str, muscles: Sequence[str], others: int, fs_hz: float, duration_s: float, *, mains_hz: float | None,
    electrode_mm: float | None, software: str,
) -> Json:  # fmt: skip
    """The _emg.json of a recording of presses. muscles : roles of its EMG channels. others : number of the others."""
    names = [MUSCLES.get(muscle.upper(), muscle) for muscle in muscles]
    placed = f"Bipolar electrodes over the bellies of: {', '.join(names)}." if names else "No EMG in this file."
    distance = {} if electrode_mm is None else {"InterelectrodeDistance": electrode_mm}
    return {
        "TaskName": task,
        "TaskDescription": "Press a soft specimen with one finger, several times, with rests between.",
        "SamplingFrequency": fs_hz,
        "PowerLineFrequency": mains_hz if mains_hz is not None else "n/a",
        "RecordingType": "continuous",
        "RecordingDuration": round(duration_s, 6),
        "SoftwareFilters": "n/a",
        "EMGReference": "bipolar",
        "EMGPlacementScheme": "Other",
        "EMGPlacementSchemeDescription": placed,
        "EMGChannelCount": len(names),
        "MiscChannelCount": others,
        "TriggerChannelCount": 0,
        **distance,
        "SoftwareVersions": software,
    }


def description(name: str, kind: str, what_made: str, authors: Sequence[str] = (), licence: str = "") -> Json:
    """The dataset_description.json of a data set; what_made : what the program did for it."""
    given: Json = {"License": licence} if licence else {}
    given |= {"Authors": list(authors)} if authors else {}
    made = {"Name": "emg2vsa", "Version": __version__, "Description": what_made}
    return {"Name": name, "BIDSVersion": BIDS_VERSION, "DatasetType": kind, **given, "GeneratedBy": [made]}


def write_json(path: Path, content: Json) -> None:
    write_text_atomic(path, json.dumps(content, indent=2) + "\n")


def write_tsv(path: Path, columns: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
    buffer = io.StringIO()
    csv.writer(buffer, delimiter="\t", lineterminator="\n").writerows([columns, *rows])
    write_text_atomic(path, buffer.getvalue())
