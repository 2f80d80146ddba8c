"""Vicon Nexus ASCII exports: the block "Devices".

Five lines stand above its rows: ``Devices``, the rate, device names (over the first column of each), channel names
behind ``Frame,Sub Frame``, units. The place of a sample is (frame - 1) x sub frames a frame + sub frame. Other blocks,
such as "Trajectories", follow after an empty line and are not read.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from emg2vsa.errors import RecordingError
from emg2vsa.readers.cells import Body
from emg2vsa.readers.opened import Contents, unique_names
from emg2vsa.readers.plain_csv import widest
from emg2vsa.readers.table_head import SNIFFED_ROWS
from emg2vsa.readers.text_file import Dialect, Line, TextFile, open_text, sniff, without_cut_line
from emg2vsa.readers.timed_columns import Column, TimedColumns
from emg2vsa.readers.units import canonical

_FRAME, _SUB_FRAME = 0, 1
_SNIFFED = 200_000
_BLOCK = re.compile(rb"^\s*\"?Devices\b[^\n]*\n", re.MULTILINE)
_EMPTY = re.compile(rb"^[ \t,;\r]*$(?<!\Z)", re.MULTILINE)


def open_recording(path: Path) -> TimedColumns:
    """Read header and frame numbers. Raises RecordingError for a damaged header, or frames that do not follow on."""
    text, cut = without_cut_line(open_text(path))
    begin = _BLOCK.search(text.data)
    if begin is None:
        raise _damaged(path, "no line 'Devices'")
    number = len(text.data[: begin.end()].splitlines()) + 1
    rate, devices, labels, units, first = _head(text, begin.end(), number)
    end = _EMPTY.search(text.data, first.start)
    data = text.data[first.start : end.start() if end else len(text.data)]
    rows = [line for line in TextFile(path, data[:_SNIFFED]).filled_lines(SNIFFED_ROWS) if line.end < _SNIFFED]
    dialect = sniff(path, None, rows or [first], data)
    names = dialect.split(labels.text)
    if len(names) <= _SUB_FRAME + 1:
        raise _damaged(path, "no channel names")
    body = Body(path, data, first.number, dialect, widest(dialect, rows or [first]), None)
    fs_hz = _rate(path, rate, dialect)
    start_s = _first_place(body, names) / fs_hz
    of_unit, of_device = dialect.split(units.text), _spread(dialect.split(devices.text), len(names))
    found = [(i, name) for i, name in enumerate(names) if i > _SUB_FRAME and name]
    if not found:
        raise _damaged(path, "no channel names")
    columns = tuple(
        Column(name, canonical(of_unit[i]) if i < len(of_unit) else None, i, fs_hz=fs_hz, start_s=start_s)
        for name, (i, _) in zip(unique_names([name for _, name in found]), found, strict=True)
    )
    aliases = {f"{of_device[i]}: {name}": k for k, (i, name) in reversed(list(enumerate(found)))}
    notes = (*cut, *filter(None, [dialect.note]))
    return TimedColumns(path, Contents(tuple(c.name for c in columns), aliases, notes), body, columns)


def _head(text: TextFile, start: int, number: int) -> list[Line]:
    """Rate, devices, labels, units and first row of samples."""
    head = [line for _, line in zip(range(5), text.lines(start, number), strict=False)]
    if len(head) < 5:
        raise _damaged(text.path, f"{len(head)} lines below 'Devices'")
    if not re.match(r'"?Frame"?\s*[,;\t]\s*"?Sub Frame', head[2].text):
        raise _damaged(text.path, f"{head[2].text[:40]!r} in line {head[2].number} instead of Frame, Sub Frame, ...")
    return head


def _rate(path: Path, line: Line, dialect: Dialect) -> float:
    cells = dialect.split(line.text)
    try:
        fs_hz = float(cells[0].replace(dialect.decimal, "."))
        if not 0 < fs_hz < 1e9:
            raise ValueError(cells[0])
    except (ValueError, IndexError) as error:
        raise _damaged(path, f"{line.text[:40]!r} as the rate in line {line.number}") from error
    return fs_hz


def _first_place(body: Body, names: Sequence[str]) -> float:
    """Samples before the first one, counted from frame 1. Every row must be the sub frame after the one above."""
    cells = body.columns({_FRAME: names[_FRAME], _SUB_FRAME: names[_SUB_FRAME]})
    frame, sub = cells[_FRAME], cells[_SUB_FRAME]
    if not (frame.size and np.isfinite(frame).all() and np.isfinite(sub).all()):
        raise _damaged(body.path, "rows without frame numbers")
    place = (frame - 1) * (sub.max() + 1) + sub
    wrong = np.flatnonzero(np.diff(place) != 1)
    if wrong.size:
        row = int(wrong[0]) + 1
        raise RecordingError(
            f"{body.path}, {body.line(row)}", wanted="the sub frame that follows the one above",
            found=f"frame {frame[row]:g}, sub frame {sub[row]:g} after frame {frame[row - 1]:g}, {sub[row - 1]:g}",
            do="Export the recording again, without gaps.",
        )  # fmt: skip
    return float(place[0])


def _spread(devices: Sequence[str], n: int) -> list[str]:
    """Device of every column: a name holds until the next one."""
    spread, current = [], ""
    for i in range(n):
        current = (devices[i] if i < len(devices) else "") or current
        spread.append(current)
    return spread


def _damaged(path: Path, found: str) -> RecordingError:
    return RecordingError(
        path, wanted="an ASCII export of Vicon Nexus with a block 'Devices'", found=found,
        do="Export the recording again from Nexus, with its devices.",
    )  # fmt: skip
