"""The files of a recording: channels and events as BDF+ (24-bit European data format), and what stands beside it."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from pathlib import Path

import edfio
import numpy as np

from casr.atomic import write_bytes_atomic
from emg2vsa.bids.names import CHANNELS, EVENTS, EVENTS_SIDECAR, SIDECAR, beside
from emg2vsa.bids.recording import CHANNEL_COLUMNS, Channel, Recording
from emg2vsa.bids.tables import described, write_json, write_tsv
from emg2vsa.errors import SettingError
from emg2vsa.settings import LABEL_CHARACTERS

_RATE_TOLERANCE = 1e-6
_LONGEST_RECORD_S = 2.0


def write_recording(root: Path, recording: Recording) -> Path:
    """The files of a recording in the data set ``root``; returns the data file, which comes last.

    Each channel has its own symmetric range, so a stored value is exact to 6e-8 of that range. Samples fill whole data
    records. SettingError : BDF cannot hold the name of a channel.
    """
    path, content = recording.name.path(root), _bdf(recording).to_bytes()
    write_json(beside(path, SIDECAR), recording.sidecar())
    cells = [channel.cells(recording.electrode_mm) for channel in recording.channels]
    write_tsv(beside(path, CHANNELS), CHANNEL_COLUMNS, cells)
    if recording.events is not None:
        write_tsv(beside(path, EVENTS), recording.columns, recording.event_rows())
    if recording.screen is not None:
        write_json(beside(path, EVENTS_SIDECAR), described(recording.columns) | recording.screen)
    write_bytes_atomic(path, content)  # who waits for it finds what belongs to it
    return path


def _bdf(recording: Recording) -> edfio.Bdf:
    started, events = recording.started, recording.events or ()
    return edfio.Bdf(
        [_signal(channel) for channel in recording.channels],
        patient=edfio.Patient(code=recording.name.participant),
        recording=edfio.Recording(startdate=started.date() if started else None, equipment_code=recording.equipment),
        starttime=started.time() if started else None,
        data_record_duration=recording.record_s,
        annotations=[edfio.EdfAnnotation(event.onset_s, event.duration_s, event.kind) for event in events],
    )


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


def short_labels(names: Sequence[str]) -> list[str]:
    """Names as BDF can hold them, in ASCII and at most 16 characters, no two alike."""
    found: list[str] = []
    for name in names:
        short = re.sub(r"[^ -~]", "", name).strip()[:LABEL_CHARACTERS] or "channel"
        number, unique = 1, short
        while unique in found:
            number += 1
            unique = f"{short[: LABEL_CHARACTERS - 1 - len(str(number))]} {number}"
        found.append(unique)
    return found


def _signal(channel: Channel) -> edfio.BdfSignal:
    if len(channel.label) > LABEL_CHARACTERS or not channel.label.isascii():
        raise SettingError(
            f"channel {channel.label!r}", found=f"{len(channel.label)} characters",
            wanted=f"a name of at most {LABEL_CHARACTERS} ASCII characters, for BDF holds no more",
            do="Shorten it, or write another format.",
        )  # fmt: skip
    limit = _two_digits_above(float(np.max(np.abs(channel.samples))))
    return edfio.BdfSignal(
        channel.samples,
        channel.fs_hz,
        label=channel.label,
        transducer_type="bipolar surface electrode" if channel.muscle else "force sensor",
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
