"""Plain CSV: a header row of channel names, units in brackets or after an underscore if any, and a time column.

``EMG (mV)``, ``Fz [N]``, ``EDC_mV``; a time column is called time, t, timestamp or X[s], with its unit in brackets or
after an underscore (``time_ms``), or holds stamps with a date or a time of day; without any, a first column that rises
and has a unit of time is one (``millis_ms``). Channels belong to the nearest time
column on their left: a file may hold several clocks. Without a time column the rate is what a line above the names
states, or unknown, and the study must state it. Lines that begin with ``#`` before the header are comments; what stands
above the names, and a row of units below them, is found by ``table_head``.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

from emg2vsa.errors import RecordingError
from emg2vsa.readers.cells import Body
from emg2vsa.readers.opened import Contents, unique_names
from emg2vsa.readers.table_head import SNIFFED_ROWS, head_of_table
from emg2vsa.readers.text_file import Dialect, Line, TextFile, open_text, sniff, without_cut_line
from emg2vsa.readers.time_stamps import are_stamps, date_of
from emg2vsa.readers.timed_columns import Column, TimedColumns
from emg2vsa.readers.units import is_glued, seconds_per, split_unit

_NUMBER = re.compile(r"[+-]?[.,]?\d[\d.,]*(e[+-]?\d+)?|nan|n/a", re.IGNORECASE)
_TIME = re.compile(
    r"(time|times|t|x|timestamps?|elapsed[ _]time|zeit|temps|tempo|tiempo|tijd|tid)(?:_(s|ms|us|min))?", re.IGNORECASE
)


def open_recording(path: Path) -> TimedColumns:
    """Validate header, dialect and time column. Raises RecordingError; cells are checked when they are read."""
    text, cut = without_cut_line(open_text(path))
    head = head_of_table(text)
    if head is None:
        raise _no_rows(text, text.filled_lines(2))
    header, rows = head.names, head.rows
    body_data = text.data[head.begin :]
    dialect = sniff(path, header, rows, body_data)
    labels = head.labels(dialect)
    _refuse_prose(path, header, rows, dialect)
    allowed = checked_width(path, dialect, labels, rows)
    channels = _columns(path, header, labels, [dialect.split(row.text) for row in rows], dialect.decimal)
    if all(column.time_index is None for column in channels):
        channels = tuple(replace(column, fs_hz=head.fs_hz) for column in channels)
    names = dialect.split(header.text)
    contents = Contents(
        tuple(c.name for c in channels),
        {spelt: i for i, c in reversed(list(enumerate(channels))) for spelt in (labels[c.index], names[c.index])},
        (*cut, *head.notes, *filter(None, [dialect.note])),
        next((date for cell in dialect.split(rows[0].text) if are_stamps([cell]) for date in [date_of(cell)]), ""),
    )
    body = Body(path, body_data, head.number, dialect, widest(dialect, rows), allowed)
    return TimedColumns(path, contents, body, channels, shared_length=True)


def _refuse_prose(path: Path, header: Line, rows: Sequence[Line], dialect: Dialect) -> None:
    """A readme, a licence or a table of words is no damaged recording: say so before its columns are discussed."""
    cells = [cell for row in rows for cell in dialect.split(row.text) if cell and not are_stamps([cell])]
    if 2 * sum(_NUMBER.fullmatch(cell) is not None for cell in cells) < len(cells):
        text = " ".join(header.text.split())
        raise RecordingError(
            path, wanted="a table of numbers below a row of channel names",
            found=f"text, {text[:60] + ('...' if len(text) > 60 else '')!r}", do="Choose the file of the recording.",
        )  # fmt: skip


def header_and_rows(text: TextFile, start: int = 0, number: int = 1) -> tuple[Line, list[Line]]:
    """The header line and the first data lines. RecordingError : fewer than two filled lines."""
    lines = text.filled_lines(SNIFFED_ROWS + 1, start, number)
    if len(lines) < 2:
        raise _no_rows(text, lines)
    return lines[0], lines[1:]


def _no_rows(text: TextFile, lines: Sequence[Line]) -> RecordingError:
    found, do = f"{len(lines)} filled lines", "Export the recording again."
    return RecordingError(text.path, wanted="a header row and data", found=found, do=do)


def widest(dialect: Dialect, rows: Sequence[Line]) -> int:
    """Most cells in any of the rows."""
    return max(len(dialect.split(row.text)) for row in rows)


def checked_width(path: Path, dialect: Dialect, labels: Sequence[str], rows: Sequence[Line]) -> int:
    """Cells a row may have: one for each name, and blank ones beyond as the first row has them.

    RecordingError : filled cells beyond the names.
    """
    cells = dialect.split(rows[0].text)
    filled = max((i for i, cell in enumerate(cells, start=1) if cell), default=0)
    if filled > len(labels):
        hint = "Separate the columns by semicolons if the numbers have decimal commas."
        raise RecordingError(
            f"{path}, line {rows[0].number}", wanted=f"{len(labels)} cells, as the header names",
            found=str(filled), do=hint if dialect.separator == "," else "Correct the header row.",
        )  # fmt: skip
    return max(len(labels), len(cells))


def time_unit_s(label: str) -> tuple[bool, float | None]:
    """(whether the label names a time column, seconds in its unit or None where it states none)."""
    name, unit = split_unit(label)
    match = _TIME.fullmatch(name)
    if match is None or (unit is not None and seconds_per(unit) is None):
        return False, None
    if name.lower() == "x" and unit is None:  # without [s] an X is more often a coordinate
        return False, None
    stated = unit or match[2]
    return True, seconds_per(stated) if stated else None


def _columns(
    path: Path, header: Line, labels: Sequence[str], rows: Sequence[Sequence[str]], decimal: str
) -> tuple[Column, ...]:
    table = [[row[i] if i < len(row) else "" for row in rows] for i in range(len(labels))]
    stamped = [are_stamps(cells) for cells in table]
    times = [(True, 1.0) if stamps else time_unit_s(label) for label, stamps in zip(labels, stamped, strict=True)]
    if not any(is_time for is_time, _ in times) and (unit_s := _unit_of_clock(labels[0], table[0], decimal)):
        times[0] = (True, unit_s)
    clocks = [i for i, (is_time, _) in enumerate(times) if is_time]
    found = [(i, *split_unit(label, glued=True)) for i, label in enumerate(labels) if not times[i][0] and label]
    if not found:
        raise RecordingError(
            f"{path}, line {header.number}",
            wanted="channels beside the time",
            found="none",
            do="Export the channels too.",
        )
    names = unique_names([name for _, name, _ in found])
    columns = []
    for name, (i, _, unit) in zip(names, found, strict=True):
        clock = max((c for c in clocks if c < i), default=clocks[0] if clocks else None)
        notes = (f"{labels[i]}: the unit {unit} was taken from the end of its name.",) if is_glued(labels[i]) else ()
        unit_s = times[clock][1] if clock is not None else 1.0
        decimals = None if clock is None else _decimals(table[clock], decimal)
        is_stamped = clock is not None and stamped[clock]
        columns.append(Column(name, unit, i, clock, unit_s, decimals=decimals, stamped=is_stamped, notes=notes))
    return tuple(columns)


def _unit_of_clock(label: str, cells: Sequence[str], decimal: str) -> float | None:
    """Seconds in the unit of time that the label of a first column ends with, where its cells rise; else None."""
    unit = split_unit(label)[1] or label.rpartition("_")[2]
    try:
        values = [float(cell.replace(decimal, ".")) for cell in cells]
    except ValueError:
        return None
    rises = len(values) > 1 and all(a < b for a, b in pairwise(values))
    return seconds_per(unit) if rises and unit != label else None


def _decimals(cells: Sequence[str], decimal: str) -> int | None:
    """Most digits behind the decimal sign; None for numbers with an exponent, whose last digit moves."""
    if any("e" in cell.lower() for cell in cells):
        return None
    # a stamp may end in a time zone
    fractions = [re.split(r"[^\d]", cell.partition(decimal)[2])[0] for cell in cells]
    return max(map(len, fractions), default=0)
