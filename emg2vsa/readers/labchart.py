"""Texts that LabChart and PowerLab export: lines such as ``Interval=`` and ``ChannelTitle=``, then rows of numbers.

A row begins with the time. The unit of a channel is that of ``UnitName=`` where the export has it, else of ``Range=``.
Each block begins with such lines again; a file of several blocks is refused, as the pause between them is not known.
"""

from __future__ import annotations

import re
from pathlib import Path

from emg2vsa.errors import RecordingError
from emg2vsa.readers.cells import Body
from emg2vsa.readers.opened import Contents, unique_names
from emg2vsa.readers.plain_csv import widest
from emg2vsa.readers.table_head import SNIFFED_ROWS
from emg2vsa.readers.text_file import Dialect, open_text, sniff, without_cut_line
from emg2vsa.readers.timed_columns import Column, TimedColumns
from emg2vsa.readers.units import canonical, seconds_per

_KEY = re.compile(r"([A-Za-z]+)=")
_COMMENT_CELLS = 2
"""Cells that a row may have behind its values, for a comment."""


def open_recording(path: Path) -> TimedColumns:
    """Read the header. Raises RecordingError for a damaged one; cells are checked when they are read."""
    text, cut = without_cut_line(open_text(path))
    said: dict[str, list[str]] = {}
    last = None
    for line in text.lines():
        if (key := _KEY.match(line.text)) is None:
            break
        said[key[1]], last = Dialect("\t", ".").split(line.text)[1:], line
    rows = text.filled_lines(SNIFFED_ROWS, last.end, last.number + 1) if last else []
    names = [name for name in said.get("ChannelTitle", []) if name]
    if last is None or not names or not rows:
        raise _damaged(path, f"{len(names)} channel titles and {'no rows' if not rows else 'rows'}")
    body = text.data[last.end :]
    if re.search(rb"^Interval=", body, re.MULTILINE):
        raise _damaged(path, "several blocks", "Export each block to a file of its own.")
    dialect = sniff(path, None, rows, body)
    fs_hz = 1 / _interval_s(path, said.get("Interval", [""])[0])
    units = said.get("UnitName") or [re.sub(r"^[\d.,\s]+", "", each) for each in said.get("Range", [])]
    columns = tuple(
        Column(name, canonical(unit) or None, i, 0, 1.0, fs_hz)
        for i, (name, unit) in enumerate(zip(unique_names(names), [*units, *[""] * len(names)], strict=False), start=1)
    )
    contents = Contents(tuple(column.name for column in columns), notes=(*cut, *filter(None, [dialect.note])))
    width = len(names) + 1 + _COMMENT_CELLS
    return TimedColumns(
        path, contents, Body(path, body, last.number + 1, dialect, widest(dialect, rows), width), columns
    )


def _interval_s(path: Path, stated: str) -> float:
    """The time between samples, as in ``0,001 s``."""
    match = re.fullmatch(r"(\d+(?:[.,]\d+)?(?:[eE][+-]?\d+)?)\s*(\S+)", stated)
    unit_s = seconds_per(match[2]) if match else None
    if match is None or unit_s is None or not (interval_s := float(match[1].replace(",", ".")) * unit_s) > 0:
        raise _damaged(path, f"{stated!r} as the interval")
    return interval_s


def _damaged(path: Path, found: str, do: str = "Export the recording again, as MATLAB if need be.") -> RecordingError:
    return RecordingError(path, wanted="a text that LabChart exported", found=found, do=do)
