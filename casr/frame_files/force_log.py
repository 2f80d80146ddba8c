"""The force log of a press: one row for each reading of the force sensor, with the last frame saved by then."""

from __future__ import annotations

import csv
import difflib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from casr.errors import FramesError
from casr.frame_files.trouble import unreadable

_TIMES = ("time_s", "frame_time_s")
REMARKS = ("doubtful:", "rejected:", "stopped:")
"A comment that begins so is what the recorder of the press thought of it, and becomes a note."
NEWTONS = {"mn": 1e-3, "cn": 1e-2, "kn": 1e3, "gf": 9.80665e-3, "kgf": 9.80665, "lbf": 4.4482216152605}
"Newtons of each unit that may end the name of a force column in place of n."


@dataclass(frozen=True)
class ForceLog:
    """Rows of a force log in the order of the file.

    time_s : (rows,) time, s; None when the log has no such column. force_n : (rows,) force, N; NaN where it is missing.
    frame_index : (rows,) index from 0 of the last frame saved, -1 before the first.
    notes : what was left out, and what the recorder of the press thought of it.
    frame_time_s : (rows,) when that frame was taken, s on the clock of ``time_s``; NaN where it is missing, None when
        the log has no such column.
    travel_mm : (rows,) how far the indenter has gone, mm from anywhere; NaN where it is missing, None as above.
    """

    time_s: NDArray[np.float64] | None
    force_n: NDArray[np.float64]
    frame_index: NDArray[np.int64]
    notes: tuple[str, ...] = ()
    frame_time_s: NDArray[np.float64] | None = None
    travel_mm: NDArray[np.float64] | None = None


def read_force_log(path: Path | str, *, column: str = "force_n") -> ForceLog:
    """A force log from delimited text with a header line.

    Columns ``force_n`` and ``frame_index`` are needed, ``time_s``, ``frame_time_s`` and ``travel_mm`` are optional,
    others are not read; their order is free. Comma, semicolon (then a decimal comma is understood) or tab between
    cells; lines starting with # and empty lines are skipped. A row for each frame is a force log too. An empty cell or
    ``nan`` is a missing force; a row without frame index is left out.

    column : the force column, for logs that hold more than one, such as ``force_filtered_n``. A name that ends in
        another unit (``NEWTONS``), such as ``force_mn``, is converted; where ``force_n`` is asked for and not there,
        the one column of that kind is taken, with a note.
    FramesError : not readable, no such columns, a row of another length, a cell that is no number, a time or frame
        index running backwards; the message names the line.
    """
    path = Path(path)
    return _log_of(_table_of(path, _text(path).splitlines()), column)


def read_growing_log(path: Path, *, column: str = "force_n") -> ForceLog | None:
    """The log that somebody is writing, as far as its lines are whole; None before the first row.

    column : of the forces, N. Errors as `read_force_log`.
    """
    text = _text(path)
    lines = text[: text.rfind("\n") + 1].splitlines()
    return None if len(_content(lines)) < 2 else _log_of(_table_of(path, lines), column)


def _log_of(table: _Table, column: str) -> ForceLog:
    force_n, unit_notes = _newtons(table, column.lower())
    frame_index = table.numbers("frame_index")
    time_s, frame_time_s, travel_mm = (
        table.numbers(name) if name in table.header else None for name in (*_TIMES, "travel_mm")
    )
    _check_frame_index(table, frame_index)
    _check_order(table, "frame_index", frame_index)
    for name, values in zip(_TIMES, (time_s, frame_time_s), strict=True):
        if values is not None:
            _check_order(table, name, values)
    placed = np.isfinite(frame_index)
    if not (placed & np.isfinite(force_n)).any():
        raise FramesError(
            table.path, wanted="rows with a force and a frame index", found="none",
            do="Give the force log of the press.",
        )  # fmt: skip
    notes = table.remarks + unit_notes + _notes(int(np.isnan(force_n).sum()), int((~placed).sum()), len(force_n))
    if frame_time_s is not None:
        notes += _notes_on_times(time_s, frame_time_s, frame_index)
    return ForceLog(
        None if time_s is None else time_s[placed],
        force_n[placed],
        frame_index[placed].astype(np.int64),
        notes,
        None if frame_time_s is None else frame_time_s[placed],
        None if travel_mm is None else travel_mm[placed],
    )


def _newtons(table: _Table, column: str) -> tuple[NDArray[np.float64], tuple[str, ...]]:
    """(rows,) force, N, of the column or of the one that holds the same in another unit."""
    stem, _, unit = column.rpartition("_")
    if unit == "n" and column not in table.header:
        others = [
            name for name in table.header if name.rpartition("_")[0] == stem and name.rpartition("_")[2] in NEWTONS
        ]
        if len(others) == 1:
            column = others[0]
            unit = column.rpartition("_")[2]
    factor = NEWTONS.get(unit) if stem else None
    if factor is None:
        return table.numbers(column), ()
    return factor * table.numbers(column), (f"force from column {column}, 1 {unit} being {factor:.6g} N",)


def _check_frame_index(table: _Table, frame_index: NDArray[np.float64]) -> None:
    wrong = (frame_index < -1) | (frame_index != np.floor(frame_index)) & np.isfinite(frame_index)
    if wrong.any():
        row = int(np.argmax(wrong))
        raise table.error(row, "a frame index: a whole number, -1 before the first frame", f"{frame_index[row]:g}")


def _check_order(table: _Table, name: str, values: NDArray[np.float64]) -> None:
    rows = np.flatnonzero(np.isfinite(values))
    back = np.flatnonzero(np.diff(values[rows]) < 0)
    if back.size:
        before, row = rows[back[0]], int(rows[back[0] + 1])
        raise table.error(row, f"{name} not below {values[before]:.12g} of the row before", f"{values[row]:.12g}")


def _notes(no_force: int, no_frame: int, n_rows: int) -> tuple[str, ...]:
    notes = []
    if no_force:
        notes.append(f"{no_force} of {n_rows} rows of the force log have no force")
    if no_frame:
        notes.append(f"{no_frame} of {n_rows} rows of the force log have no frame index and are left out")
    return tuple(notes)


def _notes_on_times(
    time_s: NDArray[np.float64] | None, frame_time_s: NDArray[np.float64], frame_index: NDArray[np.float64]
) -> tuple[str, ...]:
    if time_s is None or np.isnan(time_s).all():
        return ("frame_time_s is not used without time_s",)
    if np.isnan(frame_time_s).all():
        return ("frame_time_s is empty and not used",)
    notes = []
    if no_time := int(np.isnan(time_s).sum()):
        notes.append(f"{no_time} of {len(time_s)} rows of the force log have no time_s, and their force is not used")
    carried = np.unique(frame_index[frame_index >= 0])
    if untimed := carried.size - np.unique(frame_index[(frame_index >= 0) & np.isfinite(frame_time_s)]).size:
        notes.append(f"{untimed} of {carried.size} frames have no frame_time_s")
    return tuple(notes)


@dataclass(frozen=True)
class _Table:
    """Cells of a text file.

    path : the file. header : column names, lower case. rows : the cells below the header.
    lines : line number in the file of every row, from 1. decimal_comma : 0,5 means one half.
    remarks : of the recorder of the press (`REMARKS`).
    """

    path: Path
    header: list[str]
    rows: list[list[str]]
    lines: list[int]
    decimal_comma: bool
    remarks: tuple[str, ...] = ()

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
            self.path, wanted=f"a column {column}",
            found=f"{times} of that name" if times else f"columns {', '.join(self.header)}",
            do=f"Is it {near[0]}? Rename it or ask for that column." if near else "Name the columns in the first line.",
        )  # fmt: skip


def _content(text: list[str]) -> list[tuple[int, str]]:
    """Lines that are neither empty nor comments, with their numbers from 1."""
    return [(n, line) for n, line in enumerate(text, 1) if line.strip() and line.lstrip()[0] != "#"]


def _table_of(path: Path, text: list[str]) -> _Table:
    """Comma, semicolon or tab between cells, told by the header; # starts a comment line; decimal comma unless the
    comma separates. Raises FramesError for an unreadable or empty file and for a row of another length."""
    lines = _content(text)
    comments = [line.strip().lstrip("# ") for line in text if line.lstrip().startswith("#")]
    if len(lines) < 2:
        raise FramesError(
            path, wanted="a header line and rows", found=f"{len(lines)} lines", do="Give the force log of the press."
        )
    delimiter = next((mark for mark in "\t;" if mark in lines[0][1]), ",")
    header, *rows = csv.reader((line for _, line in lines), delimiter=delimiter, skipinitialspace=True)
    remarks = tuple(f"the recorder of the press says {text}" for text in comments if text.startswith(REMARKS))
    names, numbers = [name.strip().lower() for name in header], [n for n, _ in lines[1:]]
    table = _Table(path, names, rows, numbers, delimiter != ",", remarks)
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
