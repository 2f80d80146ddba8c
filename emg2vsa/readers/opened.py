"""What every format module offers: a validated, opened file that decodes only the channels asked for."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import RecordingError
from emg2vsa.readers.units import si_factor
from emg2vsa.recordings import Channel, ChannelInfo


@dataclass(frozen=True)
class StoredChannel:
    """One channel as the file holds it.

    samples : (n,) float64 in the file's ``unit`` (None where it states none), owned by this object.
    fs_hz : the file's own statement, or measured on its time stamps. start_s : time of the first sample.
    notes : what a reader of the results should know about this channel.
    """

    name: str
    samples: NDArray[np.float64]
    unit: str | None
    fs_hz: float
    start_s: float = 0.0
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Contents:
    """Names of a file's channels in file order, other spellings of them, and notes on the whole file.

    started : the file's own statement of when it began ("" where it makes none).
    """

    names: tuple[str, ...]
    aliases: Mapping[str, int] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    started: str = ""


class OpenRecording(Protocol):
    """A file that passed validation. ``load`` raises RecordingError for channels that cannot be used."""

    path: Path
    contents: Contents

    def describe(self) -> tuple[ChannelInfo, ...]: ...

    def load(self, indices: Sequence[int]) -> list[StoredChannel]: ...


def unique_names(names: Sequence[str]) -> tuple[str, ...]:
    """Repeated names get " #2", " #3", ... from their second use on; blank ones become "channel 5"."""
    result: list[str] = []
    for position, raw in enumerate(names, start=1):
        name = own = raw.strip() or f"channel {position}"
        uses = 1
        while name in result:
            uses += 1
            name = f"{own} #{uses}"
        result.append(name)
    return tuple(result)


_RATE_TOLERANCE = 1e-3


def usable(path: Path, name: str, channel: StoredChannel, fs_hz: float | None = None) -> StoredChannel:
    """``channel`` under the name it was asked by, with a note on its missing samples, which stay NaN.

    fs_hz : its rate by the study, which counts where the file lets none be known.

    RecordingError where the two rates differ, and where the channel is empty, of unknown rate, infinite anywhere, or
    misses half of its samples or more.
    """
    where = f"{path}, channel {name!r}"
    if channel.samples.size == 0:
        raise RecordingError(where, wanted="samples", found="none", do="Choose a channel with samples.")
    if fs_hz is not None and channel.fs_hz > 0 and abs(fs_hz - channel.fs_hz) > _RATE_TOLERANCE * channel.fs_hz:
        raise RecordingError(
            where, wanted=f"the rate that the study states, {fs_hz:g} Hz", found=f"{channel.fs_hz:.6g} Hz by the file",
            do="Leave fs_hz out, or export the recording again.",
        )  # fmt: skip
    if fs_hz is not None and not channel.fs_hz > 0:
        note = f"{name}: the file states no sampling rate; {fs_hz:g} Hz as the study states."
        channel = replace(channel, fs_hz=fs_hz, notes=(*channel.notes, note))
    if not channel.fs_hz > 0:
        raise RecordingError(
            where, wanted="a sampling rate", found="none that the file states and no column of time",
            do="State it: fs_hz = 1000 (as it was) under the channel of the study, --fs for a single file; or export "
            'the channel with its time, in a column "time (s)".',
        )  # fmt: skip
    with np.errstate(invalid="ignore", over="ignore"):
        total = channel.samples.sum()
    if not math.isfinite(total):  # one pass decides the usual case; a sum may overflow, hence the second
        missing = np.flatnonzero(np.isnan(channel.samples))
        _refuse_at(where, channel, np.flatnonzero(np.isinf(channel.samples)))
        if 2 * missing.size >= channel.samples.size:
            _refuse_at(where, channel, missing)
        if missing.size:
            note = f"{name}: {missing.size} of {channel.samples.size} samples are missing, the first at "
            channel = replace(channel, notes=(*channel.notes, note + _time(channel, int(missing[0]))))
    return replace(channel, name=name)


def _refuse_at(where: str, channel: StoredChannel, bad: NDArray[np.intp]) -> None:
    if bad.size:
        first = int(bad[0])
        raise RecordingError(
            where, wanted="finite samples",
            found=f"{channel.samples[first]} at sample {first} ({_time(channel, first)}; "
            f"{bad.size} of {channel.samples.size} samples)",
            do="Repair or cut that stretch, or choose another channel.",
        )  # fmt: skip


def _time(channel: StoredChannel, sample: int) -> str:
    return f"{channel.start_s + sample / channel.fs_hz:.6g} s"


def to_si(stored: StoredChannel) -> Channel:
    """V and N by the file's own unit; any other unit is kept as the file spells it ("" where it states none)."""
    known = si_factor(stored.unit)
    if known is None:
        return scaled(stored, 1.0, stored.unit or "", f"{stored.unit} as stored" if stored.unit else "no unit stated")
    unit, factor = known
    return scaled(stored, factor, unit, unit_step(str(stored.unit), factor, unit))


def unit_step(written: str, factor: float, unit: str) -> str:
    """ "mV x 0.001 = V", or "V as stored"."""
    return f"{unit} as stored" if factor == 1.0 else f"{written} x {factor:.10g} = {unit}"


def scaled(stored: StoredChannel, factor: float, unit: str, conversion: str) -> Channel:
    """The channel times ``factor``; works on the samples in place, which nobody else holds."""
    samples = stored.samples
    if factor != 1.0:
        samples *= factor
    return Channel(stored.name, samples, unit, stored.fs_hz, stored.start_s, conversion)
