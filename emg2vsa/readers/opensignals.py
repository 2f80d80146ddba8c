"""OpenSignals (biosignalsplux, BITalino): text exports, a JSON header above tab-separated rows.

Line 2 is ``# `` and one JSON object: per device its columns, rate, resolutions. The columns of several devices follow
each other in the order of the object. Values are counts of the converter: nothing in the file says what a count is
worth. The counter ``nSeq`` of each device says which samples were lost; BITalino's wraps at 16.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import RecordingError
from emg2vsa.readers.cells import Body
from emg2vsa.readers.on_demand import CountedRows, OnDemand, Track, counted
from emg2vsa.readers.opened import Contents, unique_names
from emg2vsa.readers.plain_csv import widest
from emg2vsa.readers.table_head import SNIFFED_ROWS
from emg2vsa.readers.text_file import open_text, sniff, without_cut_line

COUNTER = "nSeq"
_HEADER_LINES = 3
_MARKS = {"nSeq", "DI", "I1", "I2", "O1", "O2"}
"""Columns that are no analogue channel."""


@dataclass(frozen=True)
class Device:
    """One device: its columns from ``first`` on, and what its part of the header says."""

    address: str
    stated: Mapping[str, Any]
    first: int
    columns: tuple[str, ...]
    fs_hz: float


def open_recording(path: Path) -> OnDemand:
    """Read header and counters. Raises RecordingError for a damaged header, or columns that do not fit to it."""
    text, cut = without_cut_line(open_text(path))
    head = list(zip(range(_HEADER_LINES), text.lines(), strict=False))
    if len(head) < _HEADER_LINES or "EndOfHeader" not in head[-1][1].text:
        raise _damaged(path, "no line 3 '# EndOfHeader'")
    devices = _devices(path, head[1][1].text.removeprefix("#"))
    end = head[-1][1]
    rows = text.filled_lines(SNIFFED_ROWS, end.end, end.number + 1)
    if not rows:
        raise RecordingError(path, wanted="rows below the header", found="none", do="Export the recording again.")
    body_data = text.data[end.end :]
    dialect = sniff(path, None, rows, body_data)
    cells = dialect.split(rows[0].text)
    n_columns = sum(len(device.columns) for device in devices)
    if len(cells) - (cells[-1] == "") != n_columns:
        raise RecordingError(
            f"{path}, line {rows[0].number}", wanted=f"{n_columns} cells, as the header names", found=str(len(cells)),
            do="Export the recording again; a line of the header or of the data was changed.",
        )  # fmt: skip
    body = Body(path, body_data, end.number + 1, dialect, widest(dialect, rows), n_columns + 1)
    counters = body.columns(
        {d.first + d.columns.index(COUNTER): f"{COUNTER} of {d.address}" for d in devices if COUNTER in d.columns}
    )
    tracks: list[Track] = []
    places: list[tuple[int, CountedRows]] = []
    aliases: dict[str, int] = {}
    for device in devices:
        rows_of = _rows(device, counters)
        for name, other, at in _channels(device):
            unit, notes = (None, ()) if name in _MARKS else unit_of(device.stated)
            prefix = f"{device.address}: " if len(devices) > 1 else ""
            aliases[prefix + other] = len(tracks)
            tracks.append(Track(prefix + name, unit, device.fs_hz, rows_of.n_samples, notes=(*rows_of.notes, *notes)))
            places.append((device.first + at, rows_of))
    names = unique_names([track.name for track in tracks])

    def decode(indices: Sequence[int]) -> list[NDArray[np.float64]]:
        columns = body.columns({places[i][0]: names[i] for i in indices})
        return [places[i][1].placed(columns[places[i][0]]) for i in indices]

    return OnDemand(path, Contents(names, aliases, cut, started(devices[0].stated)), tuple(tracks), decode)


def unit_of(stated: Mapping[str, Any]) -> tuple[str | None, tuple[str, ...]]:
    """Unit of a device's analogue channels, and what to say of it."""
    if stated.get("convertedValues"):
        return None, ("OpenSignals converted these values; the file does not state to which unit.",)
    device = str(stated.get("device", "this device"))
    return "counts", (
        f"OpenSignals stores counts of the converter ({device}); the file does not state what a count is worth.",
    )


def started(stated: Mapping[str, Any]) -> str:
    return " ".join(str(stated[key]) for key in ("date", "time") if key in stated)


def rate_hz(path: Path, address: str, stated: Mapping[str, Any]) -> float:
    """The device's sampling rate. Raises RecordingError where it states none."""
    rate = stated.get("sampling rate")
    try:
        fs_hz = float(np.asarray(rate).reshape(-1)[0])
    except (TypeError, ValueError, IndexError):
        fs_hz = float("nan")
    if not 0 < fs_hz < 1e9:
        raise _damaged(path, f"{rate!r} as the sampling rate of {address}")
    return fs_hz


def _devices(path: Path, header: str) -> list[Device]:
    try:
        stated = json.loads(header)
    except (ValueError, RecursionError) as error:
        raise _damaged(path, f"a line 2 that is no JSON ({error})") from error
    if not isinstance(stated, dict) or not stated or not all(isinstance(each, dict) for each in stated.values()):
        raise _damaged(path, "a line 2 that names no device")
    devices, first = [], 0
    for address, each in stated.items():
        columns = each.get("column")
        if not isinstance(columns, list) or not columns or not all(isinstance(name, str) for name in columns):
            raise _damaged(path, f"{columns!r} as the columns of {address}")
        devices.append(Device(address, each, first, tuple(columns), rate_hz(path, address, each)))
        first += len(columns)
    return devices


def _channels(device: Device) -> list[tuple[str, str, int]]:
    """(name, other name, place among the device's columns); labels belong to the last columns."""
    labels = device.stated.get("label")
    labels = labels if isinstance(labels, list) and len(labels) <= len(device.columns) else []
    skipped = len(device.columns) - len(labels)
    return [
        (name, str(labels[i - skipped]) if i >= skipped else name, i)
        for i, name in enumerate(device.columns)
        if name != COUNTER
    ]


def _rows(device: Device, counters: Mapping[int, NDArray[np.float64]]) -> CountedRows:
    if COUNTER not in device.columns:
        n = next((column.size for column in counters.values()), 0)
        return CountedRows(None, n)
    column = counters[device.first + device.columns.index(COUNTER)]
    filled = np.flatnonzero(~np.isnan(column))
    n = int(filled[-1]) + 1 if filled.size else 0
    return counted(column[:n], f"{device.address}: {COUNTER}", device.fs_hz)


def _damaged(path: Path, found: str) -> RecordingError:
    return RecordingError(
        path, wanted="the JSON header of an OpenSignals export", found=found, do="Export the recording again."
    )
