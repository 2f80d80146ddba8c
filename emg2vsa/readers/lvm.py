"""LabVIEW measurement files (``.lvm``): text, a header, then segments of a header and rows each.

Separator and decimal sign are stated in the file. ``X_Columns No``: rows begin with an empty cell and time is
X0 + i x Delta_X; ``One`` and ``Multi``: one or every second column is time. A segment goes on until the next header,
whatever ``Samples`` says: with ``Multi_Headings No`` later writes have none. Segments that join in time are one
channel; after a gap a channel of its own begins ("EMG, segment 2").
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import RecordingError
from emg2vsa.readers.cells import Body
from emg2vsa.readers.on_demand import OnDemand, Track, refuse_nothing
from emg2vsa.readers.opened import Contents, unique_names
from emg2vsa.readers.plain_csv import widest
from emg2vsa.readers.table_head import SNIFFED_ROWS
from emg2vsa.readers.text_file import Dialect, TextFile, open_text, without_cut_line
from emg2vsa.readers.timing import even_clock
from emg2vsa.readers.units import canonical

_END = "***End_of_Header***"
_SEGMENT = re.compile(rb"^Channels[\t,;]", re.MULTILINE)
_SEPARATORS = {"tab": "\t", "comma": ",", "semicolon": ";"}
_WORTH_SAYING = 1e-4
"""Rounding of Delta_X, relative, from which the rate is given with its bounds."""
_MOST_LATE_S = 0.02
"""However coarse Delta_X is, segments further apart than this do not join."""
_SHORTEST_S = 1e-12
"""A Delta_X that is no longer than this, or no number that can be held, leaves the rate unknown."""
_NAN = float("nan")


@dataclass
class _Run:
    """One channel as long as its segments join. step_error_s : rounding of Delta_X, by which they may miss."""

    track: Track
    step_error_s: float
    parts: list[NDArray[np.float64]] = field(default_factory=list)
    notes: dict[str, None] = field(default_factory=dict)
    n: int = 0

    def joined_by(self, track: Track) -> bool:
        fs_hz = self.track.fs_hz
        if np.isnan(fs_hz) or abs(track.fs_hz - fs_hz) > 1e-6 * fs_hz or track.unit != self.track.unit:
            return False
        late_s = track.start_s - self.track.start_s - self.n / fs_hz
        return abs(late_s) <= 0.5 / fs_hz + min(self.n * self.step_error_s, _MOST_LATE_S)

    def add(self, samples: NDArray[np.float64], notes: tuple[str, ...]) -> None:
        self.notes.update(dict.fromkeys(notes))
        self.parts.append(samples)
        self.n += samples.size


@dataclass(frozen=True)
class _Segment:
    """stated : the cells of each header line by its key. line : number of the first."""

    stated: Mapping[str, list[str]]
    line: int
    labels: Sequence[str]
    body: Body


def open_recording(path: Path) -> OnDemand:
    """Read the file. Raises RecordingError for a damaged header, a cell that is no number, or uneven time."""
    text, cut = without_cut_line(open_text(path))
    stated, dialect = _head(text)
    starts = [match.start() for match in _SEGMENT.finditer(text.data)]
    if not starts:
        raise _damaged(path, "no line 'Channels'")
    runs: dict[tuple[int, str], list[_Run]] = {}
    first: datetime | None = None
    number, at = 1, 0
    for start, end in zip(starts, [*starts[1:], len(text.data)], strict=True):
        number += len(text.data[at:start].splitlines())
        at = start
        segment = _segment(text, dialect, start, end, number)
        begun = _moment(segment.stated)
        first = first or begun
        offset_s = (begun - first).total_seconds() if begun and first else 0.0
        for place, (track, samples, step_error_s) in enumerate(
            _channels(segment, stated.get("X_Columns", "No"), offset_s)
        ):
            of_channel = runs.setdefault((place, track.name), [])
            if not of_channel or not of_channel[-1].joined_by(track):
                of_channel.append(_Run(track, step_error_s))
            of_channel[-1].add(samples, track.notes)
    tracks, series = [], []
    for (_, name), of_channel in runs.items():
        told = _told_of_gaps(name, of_channel)
        for i, run in enumerate(of_channel, start=1):
            called = name if i == 1 else f"{name}, segment {i}"
            tracks.append(replace(run.track, name=called, n_samples=run.n, notes=(*told, *run.notes)))
            series.append(run.parts[0] if len(run.parts) == 1 else np.concatenate(run.parts))
    refuse_nothing(path, tracks)
    notes = (*cut, *filter(None, [dialect.note]))
    begun_at = f"{first:%Y-%m-%d %H:%M:%S.%f}" if first else ""
    contents = Contents(unique_names([track.name for track in tracks]), notes=notes, started=begun_at)
    return OnDemand(path, contents, tuple(tracks), lambda indices: [series[i] for i in indices])


def _told_of_gaps(name: str, runs: Sequence[_Run]) -> tuple[str, ...]:
    ends_s = [run.track.start_s + run.n / run.track.fs_hz for run in runs]
    gaps = ", ".join(
        f"{run.track.start_s - end_s:.6g} s after {end_s:.6g} s"
        for run, end_s in zip(runs[1:], ends_s[:-1], strict=True)
    )
    return (
        (f"{name}: {len(runs)} segments, with gaps of {gaps}; each segment is a channel of its own.",) if gaps else ()
    )


def _head(text: TextFile) -> tuple[dict[str, str], Dialect]:
    """Keys of the file's header, and how its numbers are written."""
    stated: dict[str, str] = {}
    for line in text.lines():
        if line.text.startswith(_END):
            break
        key, _, value = line.text.replace(",", "\t", "\t" not in line.text).partition("\t")
        stated[key.strip()] = value if key.strip() == "Decimal_Separator" else value.strip(" \t,;")
    else:
        raise _damaged(text.path, f"no line {_END}")
    separator = _SEPARATORS.get(stated.get("Separator", "Tab").lower())
    decimal = stated.get("Decimal_Separator", ".")[:1] or "."
    if separator is None or decimal not in (".", ",") or separator == decimal:
        found = f"Separator {stated.get('Separator')!r}, Decimal_Separator {stated.get('Decimal_Separator')!r}"
        raise _damaged(text.path, found)
    return stated, Dialect(separator, decimal)


def _segment(text: TextFile, dialect: Dialect, start: int, end: int, number: int) -> _Segment:
    stated: dict[str, list[str]] = {}
    lines = text.lines(start, number)
    for line in lines:
        if line.start >= end:
            raise _damaged(text.path, f"no line {_END} after line {number}")
        if line.text.startswith(_END):
            break
        key, *cells = dialect.split(line.text) or [""]
        stated[key] = cells
    names = next(lines, None)
    if names is None or names.start >= end:
        raise _damaged(text.path, f"no row of names after line {number}")
    labels = dialect.split(names.text)
    if labels[:1] != ["X_Value"]:
        raise RecordingError(
            f"{text.path}, line {names.number}", wanted="a row of names that begins with X_Value",
            found=repr(names.text[:60]), do="Export the recording again.",
        )  # fmt: skip
    data = text.data[names.end : end]
    special = data.find(b"***")  # comments and events are not part of the table
    data = data[:special] if special >= 0 else data
    rows = text.filled_lines(SNIFFED_ROWS, names.end, names.number + 1)
    n_fields = widest(dialect, [row for row in rows if row.end <= end] or [names])
    body = Body(text.path, data, names.number + 1, dialect, n_fields, None)
    return _Segment(stated, number, labels, body)


def _channels(segment: _Segment, x_columns: str, offset_s: float) -> list[tuple[Track, NDArray[np.float64], float]]:
    """(channel, samples, rounding of its step) of a segment; n_samples is not known here."""
    labels = [label for label in segment.labels if label != "Comment"]
    own_x = x_columns.lower() == "multi"
    places = [(i, i - 1) for i in range(1, len(labels), 2)] if own_x else [(i, 0) for i in range(1, len(labels))]
    with_x = x_columns.lower() in ("one", "multi")
    wanted = {i: labels[i] for i, _ in places}
    wanted |= {x: f"X_Value of {labels[i]}" for i, x in places} if with_x else {}
    columns = segment.body.columns(wanted) if segment.body.data.strip() else {i: np.empty(0) for i in wanted}
    found = []
    for place, (i, x) in enumerate(places):
        filled = np.flatnonzero(~np.isnan(columns[i]))
        samples = columns[i][: int(filled[-1]) + 1 if filled.size else 0]
        name = labels[i]
        unit = canonical(_cell(segment.stated, "Y_Unit_Label", place)) or None
        step = _cell(segment.stated, "Delta_X", place).replace(",", ".")
        step_s, start_s = _value(step), _value(_cell(segment.stated, "X0", place))
        known = step_s > _SHORTEST_S
        fs_hz, error_s = (1 / step_s, 0.5 * _last_digit(step)) if known else (_NAN, 0.0)
        notes: tuple[str, ...] = ()
        if with_x and samples.size:
            where = f"{segment.body.path}, X_Value of {name!r}"
            fs_hz, start_s = even_clock(columns[x][: samples.size], where, segment.body.line, 2e-6)
            error_s = 0.0
        elif known and abs(fs_hz - round(fs_hz)) <= 1e-9 * fs_hz:
            error_s = 0.0  # a whole number of samples a second was written with all its digits
        elif known and error_s > _WORTH_SAYING * step_s:
            low, high = 1 / (step_s + error_s), 1 / (step_s - error_s)
            notes = (f"{name}: Delta_X is rounded to {step} s; the rate lies between {low:.6g} and {high:.6g} Hz.",)
        promised = _value(_cell(segment.stated, "Samples", place))
        if samples.size < promised:
            said = f"{name}: line {segment.line} promises {promised:g} samples, {samples.size} follow."
            notes = (*notes, said)
        start_s = offset_s + (0.0 if np.isnan(start_s) else start_s)
        found.append((Track(name, unit, fs_hz, 0, start_s, notes), samples, error_s))
    return found


def _cell(stated: Mapping[str, Sequence[str]], key: str, place: int) -> str:
    cells = stated.get(key, ())
    return cells[place] if place < len(cells) else ""


def _value(text: str) -> float:
    try:
        value = float(text.replace(",", "."))
    except ValueError:
        return _NAN
    return value if np.isfinite(value) else _NAN


def _last_digit(text: str) -> float:
    """Worth of the last digit of a written number: 1e-6 for "0.000977", 1e-11 for "3.906250E-5"."""
    match = re.fullmatch(r"\s*[+-]?\d*\.?(\d*)(?:[eE]([+-]?\d{1,3}))?\s*", text)
    return float(10.0 ** (int(match[2] or 0) - len(match[1]))) if match and "." in text else 0.0


def _moment(stated: Mapping[str, Sequence[str]]) -> datetime | None:
    """Date and time of a segment; LabVIEW writes more digits of the second than a datetime holds."""
    date, time = _cell(stated, "Date", 0), _cell(stated, "Time", 0).replace(",", ".")
    try:
        return datetime.strptime(f"{date} {time[:15]}", "%Y/%m/%d %H:%M:%S.%f")
    except ValueError:
        return None


def _damaged(path: Path, found: str) -> RecordingError:
    return RecordingError(
        path, wanted="a LabVIEW measurement file", found=found, do="Export the recording again from LabVIEW."
    )
