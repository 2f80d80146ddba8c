"""A tidy table as text: one row an observation, columns by name; numbers kept as they are written, digit by digit."""

from __future__ import annotations

import csv
import difflib
import re
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path

from emg2vsa.errors import DataError
from emg2vsa.readers.text_file import WHITESPACE, Dialect, Line, TextFile, open_text, sniff

_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)(e[+-]?[0-9]+)?", re.IGNORECASE)
_DIGIT = re.compile("[1-9]")
_ABSENT = frozenset({"", "nan", "na", "n/a", "n.a.", "null", "none", "-", "."})
_SNIFFED = 50
_SHOWN = 12


@dataclass(frozen=True)
class TidyTable:
    """names : of the columns. cells : one row an observation, a cell for each name. lines : of each row in the file."""

    path: Path
    names: tuple[str, ...]
    cells: tuple[tuple[str, ...], ...]
    lines: tuple[int, ...]
    decimal: str

    def texts(self, name: str) -> list[str]:
        """A column as it is written. DataError where there is none of that name."""
        return [row[self._index(name)] for row in self.cells]

    def numbers(self, name: str) -> list[Decimal | None]:
        """A column as exact numbers, None where a cell is blank or says so (NaN, NA). DataError at anything else."""
        texts = self.texts(name)
        found = [self._number(text) for text in texts]
        for text, number, line in zip(texts, found, self.lines, strict=True):
            if number is None and text.lower() not in _ABSENT:
                raise self._no_number(name, text, line)
        return found

    def numeric(self) -> tuple[str, ...]:
        """Columns that hold numbers, and nothing but numbers and blanks."""
        columns = zip(self.names, zip(*self.cells, strict=True), strict=True)
        return tuple(
            name
            for name, texts in columns
            if any(map(self._number, texts)) and all(t.lower() in _ABSENT or self._number(t) is not None for t in texts)
        )

    def described(self) -> list[dict[str, str | int]]:
        """For each column its name, whether it holds numbers, how many different cells, and the first."""
        return [
            {"name": name, "kind": "numbers" if name in self.numeric() else "text", "different": len(set(texts)),
             "first": texts[0]}
            for name in self.names
            for texts in [self.texts(name)]
        ]  # fmt: skip

    def _number(self, text: str) -> Decimal | None:
        plain = text.replace(",", ".", 1) if self.decimal == "," else text
        if not _NUMBER.fullmatch(plain):
            return None
        size, zero = abs(float(plain)), not _DIGIT.search(plain.lower().partition("e")[0])
        # beyond the reach of float64 no test can say anything, and exact arithmetic would not end
        return Decimal(plain) if zero or 0 < size < float("inf") else None

    def _index(self, name: str) -> int:
        if name in self.names:
            return self.names.index(name)
        near = difflib.get_close_matches(name.lower(), [known.lower() for known in self.names], 1)
        hint = next((known for known in self.names if near and known.lower() == near[0]), None)
        shown = ", ".join(map(repr, self.names[:_SHOWN])) + (", ..." if len(self.names) > _SHOWN else "")
        raise DataError(
            self.path, wanted=f"a column {name!r}", found=f"columns {shown}",
            do=f"Did you mean {hint!r}?" if hint else "Choose one of these names.",
        )  # fmt: skip

    def _no_number(self, name: str, text: str, line: int) -> DataError:
        others = [other for other in self.numeric() if other != name]
        do = "Correct the cell, or leave it blank."
        if others:
            do += f" Columns of numbers: {', '.join(map(repr, others[:_SHOWN]))}."
        return DataError(
            f"{self.path}, line {line}, column {name!r}", wanted="a number that float64 can hold, or a blank cell",
            found=repr(text), do=do,
        )  # fmt: skip


def read_tidy_table(path: Path) -> TidyTable:
    """Read CSV, TSV or semicolon-separated text with a header row; separator and decimal sign are sniffed.

    Blank lines, and lines that begin with ``#``, are skipped. RecordingError for what is no text, DataError for what is
    no table.
    """
    text = open_text(path)
    return table_below(path, text, text.filled_lines(text.data.count(b"\n") + text.data.count(b"\r") + 1))


def table_below(path: Path, text: TextFile, lines: Sequence[Line]) -> TidyTable:
    """The table of these lines of ``text``, its header row first; as ``read_tidy_table``. DataError : no header and
    row, or a name that is blank or comes twice."""
    if len(lines) < 2:
        raise DataError(
            path, wanted="a header row and rows of data", found=f"{len(lines)} filled lines",
            do="Export the table again, one row an observation.",
        )  # fmt: skip
    header, rows = lines[0], lines[1:]
    dialect = sniff(path, header, rows[:_SNIFFED], text.data[rows[0].start :])
    names = dialect.split(header.text)
    _refuse_names(path, header, names)
    cells = _cells(path, dialect, rows, len(names))
    return TidyTable(path, tuple(names), cells, tuple(line.number for line in rows), dialect.decimal)


def _cells(path: Path, dialect: Dialect, rows: Sequence[Line], width: int) -> tuple[tuple[str, ...], ...]:
    """Rows with as many cells as names; blank ones beyond are dropped, missing ones are blank."""
    if dialect.separator == WHITESPACE:
        split = [line.text.split() for line in rows]
    else:
        split = list(csv.reader([line.text for line in rows], delimiter=dialect.separator, skipinitialspace=True))
    made = []
    for line, cells in zip(rows, split, strict=False):
        if any(cell.strip() for cell in cells[width:]):
            raise DataError(
                f"{path}, line {line.number}", wanted=f"{width} cells, as the header names", found=str(len(cells)),
                do="Correct the line; a decimal comma in a comma-separated file does this too.",
            )  # fmt: skip
        stripped = [cell.strip() for cell in cells[:width]]
        made.append((*stripped, *[""] * (width - len(stripped))))
    if len(split) != len(rows):
        raise DataError(
            path, wanted="one row a line", found="a cell over several lines", do="Close its quotation mark."
        )
    return tuple(made)


def _refuse_names(path: Path, header: Line, names: Sequence[str]) -> None:
    twice = [name for name in dict.fromkeys(names) if name and names.count(name) > 1]
    numbers = [name for name in names if _NUMBER.fullmatch(name)]
    if twice or len(numbers) == len(names):
        found = f"{twice[0]!r} twice" if twice else f"numbers ({', '.join(numbers[:3])})"
        raise DataError(
            f"{path}, line {header.number}", wanted="a header row of different names", found=found,
            do="Name the columns in the first row.",
        )  # fmt: skip
