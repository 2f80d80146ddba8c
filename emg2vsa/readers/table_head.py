"""Where the table of a text file begins: lines above it, the row of names, a row of units, rows of numbers."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from emg2vsa.readers.text_file import WHITESPACE, Dialect, Line, TextFile, separator_of
from emg2vsa.readers.time_stamps import is_name_of_time
from emg2vsa.readers.units import is_unit, split_unit

SNIFFED_ROWS = 50
_LONGEST_PREAMBLE = 200
"""Filled lines that may stand above the names."""
_SURE = 3
"""Rows of numbers in a row that are a table."""
_CELL = re.compile(
    r"[+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?|nan|n/a|null|-|(?:\d{4}[-/]\d{1,2}[-/]\d{1,2}T?)?(?:\d{1,2}:\d{2}:\d{2}\S*)?",
    re.IGNORECASE,
)
"""What stands between signs that separate cells or decimals, in a row of numbers and time stamps."""
_FORM_OF_STAMPS = re.compile(r"[ymdhsfTZ:./ -]*[yhms]:?[ymdhsfTZ:./ -]*", re.IGNORECASE)
"""``HH:mm:ss.fff`` in a row of units."""
_RATE = re.compile(
    r"(?:(?:sampl\w*|scan|acquisition)[ _-]*(?:rate|frequency|freq)|^frequency)\b[^\d\n]*?(\d+(?:[.,]\d+)?)\s*(k?)"
    r"(?:hz|/s|s/s)?\W*$",
    re.IGNORECASE,
)
_KEY = re.compile(r"\w*(?:names?|titles?|labels?|units?)\W*", re.IGNORECASE)
"""``CHANNEL_NAMES`` before the names, ``CHANNEL_UNITS`` before the units."""


@dataclass(frozen=True)
class TableHead:
    """names : the line of the names. units : of each column, "" where none is stated; () without a row of units.

    rows : first data lines. begin, number : where the data begin in the file, and the number of that line.
    fs_hz : a rate that one of the lines above states. notes : what is to be said of these.
    """

    names: Line
    rows: list[Line]
    begin: int
    number: int
    units: tuple[str, ...] = ()
    fs_hz: float | None = None
    notes: tuple[str, ...] = field(default=())

    def labels(self, dialect: Dialect) -> list[str]:
        """The names, each with its unit in brackets where only the row of units states one."""
        names = dialect.split(self.names.text)
        units = (*self.units, *[""] * len(names))
        return [
            f"{name} [{unit}]" if unit and name and split_unit(name)[1] is None else name
            for name, unit in zip(names, units, strict=False)
        ]


def head_of_table(text: TextFile) -> TableHead | None:
    """The head; None for a file of fewer than two filled lines.

    Names stand in the first line where numbers follow it. Else they stand above the first rows of numbers, or above the
    row of units there: words in as many cells. Where none of this is so, the first line is taken.
    """
    lines = text.filled_lines(_LONGEST_PREAMBLE + SNIFFED_ROWS + 1)
    if len(lines) < 2:
        return None
    first = _first_row(lines)
    if first is not None and first > 1:
        found = _above(lines, first)
        if found is not None:
            return found
    return TableHead(lines[0], lines[1 : SNIFFED_ROWS + 1], lines[0].end, lines[0].number + 1)


def _first_row(lines: Sequence[Line]) -> int | None:
    """Index of the first line of several rows of numbers."""
    numbers = [_are_numbers(line.text) for line in lines]
    return next((i for i in range(1, len(lines) - _SURE + 1) if all(numbers[i : i + _SURE])), None)


def _are_numbers(text: str) -> bool:
    parts = [part for part in re.split(r'[\s;,"]+', text) if part]
    return all(map(_CELL.fullmatch, parts)) and any(part[-1].isdigit() for part in parts)


def _above(lines: Sequence[Line], first: int) -> TableHead | None:
    rows = list(lines[first : first + SNIFFED_ROWS])
    for names, units in ((first - 2, first - 1), (first - 1, None)):
        if names < 0:
            continue
        dialect = Dialect(separator_of(lines[names], rows), ".")
        width = len(_filled(dialect.split(rows[0].text)))
        named = _without_key(lines[names], dialect, width)
        cells = _filled(dialect.split(named.text))
        of_units = _without_key(lines[units], dialect, width).text if units is not None else ""
        stated = tuple(_unit(cell) for cell in dialect.split(of_units)) if units is not None else ()
        if not _are_names(cells, width) or (units is not None and not _are_units(stated, width)):
            continue
        above = lines[:names]
        # two lines of words alike may be names and a damaged row: then it must be clear which are the names
        alike = [line for line in above if len(_filled(dialect.split(line.text))) == width]
        clear = any(is_name_of_time(cell) or split_unit(cell)[1] for cell in cells) or any(stated)
        if alike and not clear:
            continue
        last = lines[first - 1]
        fs_hz, notes = _said_above(above)
        known = tuple(unit or "" for unit in stated)
        return TableHead(named, rows, last.end, last.number + 1, known, fs_hz, notes)
    return None


def _without_key(line: Line, dialect: Dialect, width: int) -> Line:
    """The line without a first cell that only says what stands in the others."""
    cells = _filled(dialect.split(line.text))
    if len(cells) != width + 1 or not _KEY.fullmatch(cells[0]):
        return line
    separator = None if dialect.separator == WHITESPACE else dialect.separator
    return replace(line, text=line.text.split(separator, 1)[1])


def _filled(cells: Sequence[str]) -> list[str]:
    """Without blank cells at the end."""
    last = max((i for i, cell in enumerate(cells, start=1) if cell), default=0)
    return list(cells[:last])


def _are_names(cells: Sequence[str], width: int) -> bool:
    return 0 < width == len(cells) and all(
        re.search(r"[^\W\d_]", cell) and not _are_numbers(cell) for cell in cells if cell
    )


def _unit(cell: str) -> str | None:
    """The unit in a cell, "" in a blank one and where it tells the form of time stamps; None: it is no unit."""
    text = cell.strip().strip("[]()").strip()
    if not text or text == "-" or (":" in text and _FORM_OF_STAMPS.fullmatch(text)):
        return ""
    return text if is_unit(text) else None


def _are_units(stated: Sequence[str | None], width: int) -> bool:
    return len(stated) <= width + 1 and any(stated) and None not in stated


def _said_above(lines: Sequence[Line]) -> tuple[float | None, tuple[str, ...]]:
    """The rate that lines above a table state, and notes on them."""
    if not lines:
        return None, ()
    which = f"Line {lines[0].number}" if len(lines) == 1 else f"Lines {lines[0].number} to {lines[-1].number}"
    notes = [f"{which} above the names {'is' if len(lines) == 1 else 'are'} no part of the table."]
    found = {
        float(match[1].replace(",", ".")) * (1000.0 if match[2] else 1.0)
        for line in lines
        if (match := _RATE.search(line.text)) is not None
    }
    fs_hz = found.pop() if len(found) == 1 else None
    return (fs_hz if fs_hz else None), tuple(notes)
