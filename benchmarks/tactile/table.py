"""Tables of a benchmark: printed in columns, kept as CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from casr.atomic import write_text_atomic

Cell = str | float | None
TOO_LONG = 1e5
"Printed with an exponent from here on."


@dataclass(frozen=True)
class Table:
    """Rows under a heading.

    Parameters
    ----------
    name : file name without suffix.
    title : one line above.
    columns : heading and format of each, e.g. ``("ms", ".2f")``; the first is left aligned, the others right.
    rows : one cell per column; None where a method does not give the number.
    notes : lines below.
    """

    name: str
    title: str
    columns: tuple[tuple[str, str], ...]
    rows: Sequence[Sequence[Cell]]
    notes: tuple[str, ...] = ()

    def text(self) -> str:
        """The table as lines of equal columns."""
        shown = [[heading for heading, _ in self.columns]]
        shown += [[_shown(cell, form) for cell, (_, form) in zip(row, self.columns, strict=True)] for row in self.rows]
        widths = [max(map(len, column)) for column in zip(*shown, strict=True)]
        lines = ["  ".join([row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:])]).rstrip() for row in shown]
        return "\n".join([self.title, *lines, *self.notes])

    def write(self, folder: Path) -> None:
        """``<name>.csv`` with full digits."""
        lines = io.StringIO()
        writer = csv.writer(lines, lineterminator="\n")
        writer.writerow([heading for heading, _ in self.columns])
        writer.writerows([["" if cell is None else cell for cell in row] for row in self.rows])
        write_text_atomic(folder / f"{self.name}.csv", lines.getvalue())


def _shown(cell: Cell, form: str) -> str:
    if cell is None:
        return "-"
    if isinstance(cell, str):
        return cell
    return format(cell, ".1e" if abs(cell) >= TOO_LONG else form)
