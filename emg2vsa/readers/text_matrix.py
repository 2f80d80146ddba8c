"""Headerless number tables: channels are rows or columns, whichever are fewer, and one of them may be the time.

The first row or column whose values rise in even steps is the time, in seconds; without one the rate is unknown, and
the study must state it. The others are named by their place in the file: "row 2", "column 3".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import RecordingError
from emg2vsa.readers.cells import Body
from emg2vsa.readers.opened import Contents, StoredChannel
from emg2vsa.readers.text_file import Dialect, Line, TextFile, open_text, sniff, without_cut_line
from emg2vsa.readers.timing import even_clock
from emg2vsa.recordings import ChannelInfo

_MOST_ROWS = 1000
"""A table with more rows than this and than columns has its channels in columns."""
_TIMED = ("The file has no header: the time was recognised by its even steps, in seconds.",)


@dataclass(frozen=True)
class TextMatrix:
    """series : (channels, n), time excluded."""

    path: Path
    contents: Contents
    series: NDArray[np.float64]
    fs_hz: float
    start_s: float

    def describe(self) -> tuple[ChannelInfo, ...]:
        return tuple(ChannelInfo(name, None, self.fs_hz, self.series.shape[1]) for name in self.contents.names)

    def load(self, indices: Sequence[int]) -> list[StoredChannel]:
        names = self.contents.names
        return [StoredChannel(names[i], self.series[i].copy(), None, self.fs_hz, self.start_s) for i in indices]


def open_recording(path: Path) -> TextMatrix:
    """Read the table and find its time. Raises RecordingError with the line of a fault."""
    text = open_text(path)
    lines = text.filled_lines(_MOST_ROWS + 1)
    dialect = sniff(path, None, lines[:200], text.data)
    width = len(dialect.split(lines[0].text))
    by_rows = len(lines) <= _MOST_ROWS and len(lines) < width
    whole, cut = without_cut_line(text)
    if not by_rows:
        matrix = _from_columns(whole, dialect, lines)
    else:
        matrix = _from_rows(path, dialect, lines, -1 if cut else None)
        if cut:
            cut = (
                "The last row has no line end and may be cut in the middle of a number; its last value was left out.",
            )
    word = "row" if by_rows else "column"
    time = next((i for i, values in enumerate(matrix) if _is_clock(values)), None)
    names = tuple(f"{word} {i + 1}" for i in range(matrix.shape[0]) if i != time)
    if time is None or not names:
        notes = ("The file has no header and no time.", *cut, *filter(None, [dialect.note]))
        return TextMatrix(path, Contents(names, {}, notes), matrix, float("nan"), 0.0)
    fs_hz, start_s = even_clock(matrix[time], f"{path}, {word} {time + 1}", lambda i: f"value {i + 1}")
    notes = (*_TIMED, *cut, *filter(None, [dialect.note]))
    return TextMatrix(path, Contents(names, {}, notes), np.delete(matrix, time, axis=0), fs_hz, start_s)


def _is_clock(values: NDArray[np.float64]) -> bool:
    """Even steps of less than half a second (steps of one are a count, not a time)."""
    if not np.isfinite(values).all():
        return False
    step = np.diff(values)
    return bool(step.size and step.min() > 0 and step.max() < min(0.5, 1.5 * np.median(step)))


def _from_rows(path: Path, dialect: Dialect, lines: Sequence[Line], end: int | None) -> NDArray[np.float64]:
    """end : the cells of each line up to here are used."""
    rows = []
    for line in lines:
        cells = dialect.split(line.text)[:end]
        try:
            rows.append(np.array([cell.replace(dialect.decimal, ".") for cell in cells], dtype=np.float64))
        except ValueError as error:
            raise RecordingError(
                f"{path}, line {line.number}",
                wanted="numbers",
                found=str(error).rpartition(": ")[2],
                do="Correct the cell.",
            ) from error
        if rows[-1].size != rows[0].size:
            raise RecordingError(
                f"{path}, line {line.number}", wanted=f"{rows[0].size} values, as in line {lines[0].number}",
                found=str(rows[-1].size), do="Export the table again.",
            )  # fmt: skip
    return np.array(rows)


def _from_columns(text: TextFile, dialect: Dialect, lines: Sequence[Line]) -> NDArray[np.float64]:
    width = len(dialect.split(lines[0].text))
    body = Body(text.path, text.data[lines[0].start :], lines[0].number, dialect, width, width)
    columns = body.columns({i: f"column {i + 1}" for i in range(width)})
    matrix = np.array([columns[i] for i in range(width)])
    blank = np.isnan(matrix).all(axis=0)
    return matrix[:, : matrix.shape[1] - int(np.argmin(blank[::-1]))]
