"""Numbers from delimited text with a header line, each cell traceable to its line."""

from __future__ import annotations

import csv
import difflib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from casr.errors import FramesError
from casr.frame_files.trouble import unreadable


@dataclass(frozen=True)
class Table:
    """Cells of a text file.

    Parameters
    ----------
    path : the file.
    header : column names, lower case.
    rows : the cells below the header.
    lines : line number in the file of every row, from 1.
    decimal_comma : 0,5 means one half.
    """

    path: Path
    header: list[str]
    rows: list[list[str]]
    lines: list[int]
    decimal_comma: bool

    def numbers(self, column: str) -> NDArray[np.float64]:
        """(rows,) values of a column; NaN for an empty cell. Raises FramesError for a cell that is no number."""
        place = self._place(column)
        cells = [row[place].strip() or "nan" for row in self.rows]
        if self.decimal_comma:
            cells = [cell.replace(",", ".") for cell in cells]
        try:
            values = np.array([float(cell) for cell in cells])
        except ValueError:
            bad = next(row for row, cell in enumerate(cells) if not _is_number(cell))
            raise self.error(bad, f"a number in {column}", repr(self.rows[bad][place])) from None
        if np.isinf(values).any():
            bad = int(np.argmax(np.isinf(values)))
            raise self.error(bad, f"a finite number in {column}", repr(self.rows[bad][place]))
        return values

    def error(self, row: int, wanted: str, found: str) -> FramesError:
        """Something is wrong in one row."""
        return FramesError(
            f"{self.path}, line {self.lines[row]}", wanted=wanted, found=found, do="Correct or remove this line."
        )

    def _place(self, column: str) -> int:
        times = self.header.count(column)
        if times == 1:
            return self.header.index(column)
        near = difflib.get_close_matches(column, self.header, n=1)
        raise FramesError(
            self.path,
            wanted=f"a column {column}",
            found=f"{times} of that name" if times else f"columns {', '.join(self.header)}",
            do=f"Is it {near[0]}? Rename it or ask for that column." if near else "Name the columns in the first line.",
        )


def read_table(path: Path) -> Table:
    """Comma, semicolon or tab between cells, told by the header; # starts a comment line; decimal comma unless the
    comma separates. Raises FramesError for an unreadable or empty file and for a row of another length."""
    lines = [
        (n, line) for n, line in enumerate(_text(path).splitlines(), 1) if line.strip() and line.lstrip()[0] != "#"
    ]
    if len(lines) < 2:
        raise FramesError(
            path, wanted="a header line and rows", found=f"{len(lines)} lines", do="Give the force log of the press."
        )
    delimiter = next((mark for mark in "\t;" if mark in lines[0][1]), ",")
    header, *rows = csv.reader((line for _, line in lines), delimiter=delimiter, skipinitialspace=True)
    table = Table(path, [name.strip().lower() for name in header], rows, [n for n, _ in lines[1:]], delimiter != ",")
    for row, cells in enumerate(rows):
        if len(cells) != len(header):
            raise table.error(row, f"{len(header)} cells as in the header", f"{len(cells)}")
    return table


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise unreadable(path, error) from error
    except UnicodeDecodeError as error:
        raise FramesError(path, wanted="text in UTF-8", found=str(error), do="Save it as CSV in UTF-8.") from error


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
