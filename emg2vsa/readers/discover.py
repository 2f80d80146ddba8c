"""CSV exports of Trigno Discover (1.4.2 to 1.7.0 seen; later ones add header rows, which are skipped).

Rows 1-3: application, date, collection length. Then sensor names (only over a sensor's first column), sensor modes,
channel names ("EMG 1 (mV)"; in 1.4.2 "EMG 1 (1259Hz)", without a unit) and, from 1.5 on, rates ("1259.2593 Hz"; "-1 Hz"
for devices without one). Row i is each channel's own i-th sample, not a common time: the rate row alone says when a
sample was taken. With "Time Series" columns each channel has its own time.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import islice
from pathlib import Path

from emg2vsa.errors import RecordingError
from emg2vsa.readers.cells import Body
from emg2vsa.readers.opened import Contents, unique_names
from emg2vsa.readers.plain_csv import widest
from emg2vsa.readers.table_head import SNIFFED_ROWS
from emg2vsa.readers.text_file import Dialect, Line, open_text, sniff, without_cut_line
from emg2vsa.readers.timed_columns import Column, TimedColumns
from emg2vsa.readers.units import split_unit

_FRAME_S = 0.0135
_TIME_SERIES = re.compile(r".*\bTime Series\s*\((s)\)", re.IGNORECASE)
_CHANNEL_RATE = re.compile(r"(.*?)\s*\(\s*(-?\d+(?:[.,]\d+)?)\s*Hz\s*\)")
_RATE = re.compile(r"(-?\d+(?:[.,]\d+)?)\s*Hz")
_DATA = re.compile(r"[+-]?(\d|[.,]\d)[\d.,eE+-]*|NaN|")


def open_recording(path: Path) -> TimedColumns:
    """Validate the header rows. Raises RecordingError; cells are checked when they are read."""
    text, cut = without_cut_line(open_text(path))
    head = list(islice(text.lines(), 40))
    separator = next((s for s in ";\t," if s in head[0].text), ",")
    heading = Dialect(separator, ".")
    at = _channel_row(path, heading, head)
    first = _first_data_row(path, heading, head, at)
    rows = text.filled_lines(SNIFFED_ROWS, head[first].start, head[first].number)
    body_data = text.data[head[first].start :]
    dialect = Dialect(separator, "." if separator == "," else sniff(path, None, rows, body_data).decimal)
    columns = _columns(heading, head, at, first)
    notes = (*cut, *filter(None, [dialect.note]))
    contents = Contents(tuple(c.name for c in columns), {}, notes, _started(heading, head))
    body = Body(path, body_data, head[first].number, dialect, widest(dialect, rows), None)
    return TimedColumns(path, contents, body, columns)


def _channel_row(path: Path, heading: Dialect, head: Sequence[Line]) -> int:
    """Index of the row of channel names: the one below the sensor modes."""
    for i, line in enumerate(head[:-1]):
        if heading.split(line.text)[:1] and heading.split(line.text)[0].startswith("sensor mode"):
            return i + 1
    raise RecordingError(
        path, wanted="a row of sensor modes above the channel names", found="none in the first lines",
        do="Export the recording again from Trigno Discover.",
    )  # fmt: skip


def _first_data_row(path: Path, heading: Dialect, head: Sequence[Line], at: int) -> int:
    for i in range(at + 1, len(head)):
        cells = [cell for cell in heading.split(head[i].text) if cell]
        if cells and _DATA.fullmatch(cells[0]):
            return i
    raise RecordingError(path, wanted="samples below the header", found="none", do="Export the recording again.")


def _started(heading: Dialect, head: Sequence[Line]) -> str:
    for line in head[:5]:
        cells = heading.split(line.text)
        if cells and cells[0].startswith("Date/Time"):
            return " ".join(cells[1:]).strip()
    return ""


def _columns(heading: Dialect, head: Sequence[Line], at: int, first: int) -> tuple[Column, ...]:
    labels = heading.split(head[at].text)
    sensors = _spread(heading.split(head[at - 2].text), len(labels))
    rates = next(
        (cells for line in head[at + 1 : first] if any(map(_RATE.fullmatch, cells := heading.split(line.text)))), []
    )
    names, found, clock = [], [], None
    for i, label in enumerate(labels):
        if _TIME_SERIES.fullmatch(label):
            clock = i
        elif label:
            name, unit, fs_hz, notes = _channel(label, rates[i] if i < len(rates) else "")
            names.append(f"{sensors[i]}: {name}" if sensors[i] else name)
            found.append((unit, i, clock, fs_hz, notes))
    return tuple(
        Column(name, unit, i, clock, 1.0, fs_hz, digits=7 if clock is not None else None, notes=notes)
        for name, (unit, i, clock, fs_hz, notes) in zip(unique_names(names), found, strict=True)
    )


def _spread(sensors: Sequence[str], n: int) -> list[str]:
    """Sensor of every column: a name holds until the next one."""
    spread, current = [], ""
    for i in range(n):
        current = (sensors[i] if i < len(sensors) else "") or current
        spread.append(current)
    return spread


def _channel(label: str, rate: str) -> tuple[str, str | None, float | None, tuple[str, ...]]:
    """(name, unit, rate, notes) from a channel cell and its rate cell."""
    old = _CHANNEL_RATE.fullmatch(label)
    if old is None:
        match = _RATE.fullmatch(rate)
        fs_hz = float(match[1].replace(",", ".")) if match else None
        return *split_unit(label), fs_hz if fs_hz is not None and fs_hz > 0 else None, ()
    stated = float(old[2].replace(",", "."))
    exact = round(stated * _FRAME_S) / _FRAME_S
    if round(exact) != stated or exact <= 0:
        return old[1], None, stated if stated > 0 else None, ()
    return (
        old[1],
        None,
        exact,
        (f"{old[1]}: stated as {stated:g} Hz; {exact:.4f} Hz was used (whole samples in 13.5 ms).",),
    )
