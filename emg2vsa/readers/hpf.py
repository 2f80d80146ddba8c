"""Delsys EMGworks 4 (``.hpf``): Data Translation's High Performance File Format.

A row of chunks ``i64 id, i64 size`` (size with this head), little-endian: the header (0x1000), the channels of a group
as XML (0x2000), samples of a group (0x3000: group, index of the first sample, then offset and length for each channel),
events and an index, which are not needed. Samples are physical already; the gains in the XML are not to be applied. All
channels of a group are stored at one rate, RequestedPerChannelSampleRate; a slower sensor's values are repeated.
Layout: "DT High Performance File Format Specification" (Data Translation 22760, 2007), checked on four files.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import RecordingError
from emg2vsa.readers.on_demand import OnDemand, Track, refuse_nothing
from emg2vsa.readers.opened import Contents, unique_names
from emg2vsa.readers.units import canonical, si_factor

_HEADER, _CHANNELS, _DATA = 0x1000, 0x2000, 0x3000
_HEADER_XML, _CHANNELS_XML = 36, 24
_STORED: dict[str, np.dtype[np.floating]] = {"Float": np.dtype("<f4"), "Double": np.dtype("<f8")}
_MOST_XML = 64_000_000
_MOST_CHANNELS = 65536


@dataclass(frozen=True)
class _Piece:
    """The samples of one channel in one chunk: index of the first, where they lie in the file, and their bytes."""

    first: int
    at: int
    n_bytes: int


@dataclass
class _Group:
    """channels : the XML of each channel. chunks : first sample, and offset and length by DataIndex."""

    channels: list[ElementTree.Element] = field(default_factory=list)
    chunks: list[tuple[int, list[tuple[int, int]]]] = field(default_factory=list)


def open_recording(path: Path) -> OnDemand:
    """Read the heads of all chunks. Raises RecordingError for a damaged file, lost chunks, or no samples."""
    groups: dict[int, _Group] = {}
    notes: list[str] = []
    started = ""
    with path.open("rb") as file:
        for kind, at, size in _chunks(path, file, notes):
            if kind == _HEADER:
                started = _xml(path, file, at + _HEADER_XML, at + size).findtext("RecordingDate") or ""
            elif kind == _CHANNELS:
                (number,) = _unpack(path, file, at + 16, struct.Struct("<i"))
                root = _xml(path, file, at + _CHANNELS_XML, at + size)
                groups.setdefault(number, _Group()).channels += root.findall("ChannelInformation")
            elif kind == _DATA:
                number, first, n = _unpack(path, file, at + 16, struct.Struct("<iqi"))
                if not 0 <= n <= min((size - 32) // 8, _MOST_CHANNELS) or not 0 <= first < 2**62:
                    raise _damaged(path, at, f"{n} channels in a chunk of {size} bytes")
                flat = _unpack(path, file, at + 32, struct.Struct(f"<{2 * n}i"))
                pieces = list(zip(flat[::2], flat[1::2], strict=True))
                if any(offset < 0 or length < 0 or offset + length > size for offset, length in pieces):
                    raise _damaged(path, at, "samples that lie outside their chunk")
                groups.setdefault(number, _Group()).chunks.append((first, [(at + o, length) for o, length in pieces]))
    tracks, places = [], []
    for number, group in sorted(groups.items()):
        for channel in group.channels:
            track, place = _track(path, number, group, channel)
            if track is not None:
                tracks.append(track)
                places.append(place)
    refuse_nothing(path, tracks)

    def decode(indices: Sequence[int]) -> list[NDArray[np.float64]]:
        with path.open("rb") as file:
            return [_samples(path, file, *places[i]) for i in indices]

    names = unique_names([track.name for track in tracks])
    return OnDemand(path, Contents(names, notes=tuple(notes), started=started), tuple(tracks), decode)


def _chunks(path: Path, file: BinaryIO, notes: list[str]) -> Iterator[tuple[int, int, int]]:
    """(id, where it begins, its bytes) of every whole chunk."""
    end = path.stat().st_size
    at = 0
    while at < end:
        if end - at < 16:
            notes.append(f"The file is incomplete: it ends inside the chunk at byte {at}.")
            return
        kind, size = _unpack(path, file, at, struct.Struct("<qq"))
        if size < 16 or kind <= 0:
            raise _damaged(path, at, f"a chunk of kind {kind} and {size} bytes")
        if size > end - at:
            lost = "; the samples in it were left out" if kind == _DATA else ""
            notes.append(f"The file is incomplete: it ends inside the chunk at byte {at}{lost}.")
            return
        yield kind, at, size
        at += size


def _track(
    path: Path, number: int, group: _Group, channel: ElementTree.Element
) -> tuple[Track | None, tuple[np.dtype[np.floating], list[_Piece]]]:
    """The channel and where its samples lie; None for a time axis and the like."""
    name = (channel.findtext("Name") or "").strip()
    stored = _STORED.get(kind := channel.findtext("DataType") or "")
    if channel.findtext("ChannelType") not in (None, "", "RandomDataChannel"):
        return None, (_STORED["Float"], [])
    where = f"{path}, channel {name!r}"
    if stored is None or channel.find("DataScale") is not None or channel.find("SensorScale") is not None:
        raise RecordingError(
            where, wanted="physical samples (Float or Double), as Delsys writes them",
            found=f"scaled ones of type {kind!r}", do="Open the file in Delsys EMGworks and export it as CSV.",
        )  # fmt: skip
    index = int(_number(where, channel, "DataIndex"))
    fs_hz = _number(where, channel, "RequestedPerChannelSampleRate") or _number(where, channel, "PerChannelSampleRate")
    sensor_hz = _number(where, channel, "PerChannelSampleRate") or fs_hz
    pieces = []
    for first, of_chunk in sorted(group.chunks):
        if not 0 <= index < len(of_chunk) or of_chunk[index][1] % stored.itemsize:
            raise _damaged(path, of_chunk[0][0] if of_chunk else 0, f"no samples of {name!r} in a chunk")
        pieces.append(_Piece(first, *of_chunk[index]))
    n = 0
    for piece in pieces:
        if piece.first != pieces[0].first + n:
            raise RecordingError(
                where, wanted=f"samples from {pieces[0].first + n} on (group {number})",
                found=f"those from {piece.first} on", do="Copy the file again; a part of it is lost.",
            )  # fmt: skip
        n += piece.n_bytes // stored.itemsize
    unit = canonical(channel.findtext("Unit") or "") or None
    unit_is_voltage = (si_factor(unit) or ("",))[0] == "V"
    notes: tuple[str, ...] = ()
    if abs(sensor_hz - fs_hz) > 1e-3 * fs_hz:
        said = f"values of a sensor of {sensor_hz:.6g} Hz are repeated to {fs_hz:.6g} Hz."
        notes = (f"{name}: {said}" if unit_is_voltage else f"Channels that are no EMG: {said}",)
    start_s = pieces[0].first / fs_hz if pieces and fs_hz > 0 else 0.0
    return Track(name, unit, fs_hz if fs_hz > 0 else math.nan, n, start_s, notes), (stored, pieces)


def _number(where: str, channel: ElementTree.Element, key: str) -> float:
    text = (channel.findtext(key) or "").strip()
    try:
        value = float(text)
        if not 0 <= value < 1e9:
            raise ValueError(text)
    except ValueError as error:
        raise RecordingError(
            f"{where}, {key}", wanted="a number of 0 or more", found=repr(text[:40]), do="Copy the file again."
        ) from error
    return value


def _samples(
    path: Path, file: BinaryIO, stored: np.dtype[np.floating], pieces: Sequence[_Piece]
) -> NDArray[np.float64]:
    parts = []
    for piece in pieces:
        file.seek(piece.at)
        with np.errstate(invalid="ignore"):  # what a NaN of a damaged file may raise
            parts.append(np.frombuffer(_read(path, file, piece.n_bytes), stored).astype(np.float64))
    return np.concatenate(parts) if parts else np.empty(0)


def _xml(path: Path, file: BinaryIO, start: int, end: int) -> ElementTree.Element:
    file.seek(start)
    raw = file.read(max(0, min(end - start, _MOST_XML))).partition(b"\0")[0]
    try:
        return ElementTree.fromstring(raw)
    except (ElementTree.ParseError, ValueError, LookupError) as error:  # an encoding nobody knows is a LookupError
        raise _damaged(path, start, f"a description that is no XML ({error})") from error


def _unpack(path: Path, file: BinaryIO, at: int, layout: struct.Struct) -> tuple[int, ...]:
    file.seek(at)
    return layout.unpack(_read(path, file, layout.size))


def _read(path: Path, file: BinaryIO, n: int) -> bytes:
    raw = file.read(n)
    if len(raw) < n:
        raise _damaged(path, file.tell(), "the end of the file")
    return raw


def _damaged(path: Path, at: int, found: str) -> RecordingError:
    return RecordingError(
        f"{path}, byte {at}", wanted="an undamaged HPF file", found=found,
        do="Copy the file again, or export it from Delsys EMGworks as CSV.",
    )  # fmt: skip
