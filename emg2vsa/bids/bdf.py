"""Channels as BDF+ (24-bit European data format)."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from datetime import datetime

import numpy as np
from edfio import Bdf, BdfSignal, EdfAnnotation, Patient, Recording

from emg2vsa.bids.channels import Channel
from emg2vsa.bids.events import Event
from emg2vsa.errors import SettingError
from emg2vsa.settings import LABEL_CHARACTERS

_RATE_TOLERANCE = 1e-6
_LONGEST_RECORD_S = 2.0


def bdf_bytes(
    channels: Sequence[Channel],
    events: Iterable[Event],
    *,
    patient: str,
    equipment: str,
    record_s: float,
    started: datetime | None = None,
) -> bytes:
    """The file of channels, with events as annotations.

    Each channel has its own symmetric range, so a stored value is exact to 6e-8 of that range. Samples fill whole data
    records of ``record_s``. SettingError for a name that BDF cannot hold.
    """
    file = Bdf(
        [_signal(channel) for channel in channels],
        patient=Patient(code=patient),
        recording=Recording(startdate=started.date() if started else None, equipment_code=equipment),
        starttime=started.time() if started else None,
        data_record_duration=record_s,
        annotations=[EdfAnnotation(event.onset_s, event.duration_s, event.kind) for event in events],
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


def _signal(channel: Channel) -> BdfSignal:
    if len(channel.label) > LABEL_CHARACTERS or not channel.label.isascii():
        raise SettingError(
            f"channel {channel.label!r}",
            wanted=f"a name of at most {LABEL_CHARACTERS} ASCII characters, for BDF holds no more",
            found=f"{len(channel.label)} characters",
            do="Shorten it, or write another format.",
        )
    limit = _two_digits_above(float(np.max(np.abs(channel.samples))))
    return BdfSignal(
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
