"""Delsys EMGworks 3 (``.emg``, "DEMG"), version 3: a header, then int16 samples interleaved by sample, little-endian.

EMG at the skin = (stored number x volts per bit - offset) / system gain. Object records (markers) follow the samples.
Layout: the reader of the Biomechanical Toolkit (BSD-3, 2015), checked on a file against the HPF made from it by
EMGworks. Versions 1, 2 and 4 have another layout; no file of them was seen.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import RecordingError
from emg2vsa.readers.on_demand import OnDemand, Track, refuse_nothing
from emg2vsa.readers.opened import Contents, unique_names
from emg2vsa.readers.units import canonical

_VERSION = 3
_FIXED = struct.Struct("<11s11s255sIIIIIdd7I")
_LONGEST_TEXT = 1024
_MOST_CHANNELS = 4096


@dataclass(frozen=True)
class _Scale:
    system_gain: float
    ad_gain: float
    volts_per_bit: float
    offset: float
    high_pass_hz: float
    low_pass_hz: float


def open_recording(path: Path) -> OnDemand:
    """Read the header. Raises RecordingError for a damaged one, another version than 3, or no samples."""
    with path.open("rb") as file:
        version, _ = _unpacked(path, file, struct.Struct("<4xHI"))
        if version != _VERSION:
            raise RecordingError(
                path, wanted=f"a DEMG file of version {_VERSION}", found=f"version {version}",
                do="Open it in Delsys EMGworks and export it as CSV.",
            )  # fmt: skip
        *_, n_channels, promised, _wanted, fs_hz, _wanted_hz, at, _, _, _, _, _, n_video = _unpacked(path, file, _FIXED)
        if not (0 < n_channels <= _MOST_CHANNELS and 0 < fs_hz < np.inf):
            raise _damaged(path, f"{n_channels} channels at {fs_hz:g} Hz")
        _text(path, file, n_video)
        headers = [_channel(path, file) for _ in range(n_channels)]
        end = file.tell()
    held = max(0, path.stat().st_size - at) // (2 * n_channels)
    n = min(promised, held)
    notes = []
    if n < promised:
        notes.append(f"The header promises {promised} samples a channel, the file holds {n}: it is incomplete.")
    if end != at:
        notes.append(
            f"The header ends at byte {end}, but states that the samples begin at byte {at}; the latter counts."
        )
    tracks = tuple(Track(name, unit, fs_hz, n, notes=_notes(name, scale)) for name, unit, scale in headers)
    refuse_nothing(path, tracks)

    def decode(indices: Sequence[int]) -> list[NDArray[Any]]:
        stored = np.fromfile(path, "<i2", n * n_channels, offset=at)
        scales = [headers[i][2] for i in indices]
        with np.errstate(over="ignore"):  # of a damaged scale; what is not finite is refused
            return [
                (stored[i::n_channels] * scale.volts_per_bit - scale.offset) / scale.system_gain
                for i, scale in zip(indices, scales, strict=True)
            ]

    return OnDemand(path, Contents(unique_names([track.name for track in tracks]), notes=tuple(notes)), tracks, decode)


def _channel(path: Path, file: BinaryIO) -> tuple[str, str | None, _Scale]:
    """(label, unit, scale) of the channel header that begins here."""
    _unpacked(path, file, struct.Struct("<I"))
    unit = _text(path, file, *_unpacked(path, file, struct.Struct("<I")))
    label = _text(path, file, *_unpacked(path, file, struct.Struct("<I")))
    scale = _Scale(*_unpacked(path, file, struct.Struct("<6d")))
    if not (np.isfinite([scale.system_gain, scale.volts_per_bit, scale.offset]).all() and scale.system_gain):
        raise _damaged(
            path, f"a system gain of {scale.system_gain:g} and {scale.volts_per_bit:g} V per bit ({label!r})"
        )
    return label, canonical(unit) or None, scale


def _notes(name: str, scale: _Scale) -> tuple[str, ...]:
    if scale.ad_gain == 1:
        return ()
    return (f"{name}: the gain of the converter, {scale.ad_gain:g}, is stated but was not applied.",)


def _text(path: Path, file: BinaryIO, n: int) -> str:
    if n > _LONGEST_TEXT:
        raise _damaged(path, f"a text of {n} characters")
    text = file.read(n)
    if len(text) < n:
        raise _damaged(path, f"an end at byte {file.tell()}")
    return text.partition(b"\0")[0].decode("latin-1").strip()


def _unpacked(path: Path, file: BinaryIO, layout: struct.Struct) -> tuple[Any, ...]:
    raw = file.read(layout.size)
    if len(raw) < layout.size:
        raise _damaged(path, f"an end at byte {file.tell()}")
    return layout.unpack(raw)


def _damaged(path: Path, found: str) -> RecordingError:
    return RecordingError(path, wanted="a whole DEMG header", found=found, do="Copy the file again.")
