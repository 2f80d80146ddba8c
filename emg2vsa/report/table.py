"""One table: what programs read of it (CSV, every digit) and what people see (rounded, here as HTML)."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from emg2vsa.figures.activity_scale import ActivityScale
from emg2vsa.report.wording import UNDEFINED, number, p_parts

Cell = str | int | float | bool | None


@dataclass(frozen=True)
class Column:
    """key : what is shown, and its name in CSV with its unit, unless ``name`` is that. head : for people.

    factor, digits : how a number is shown to people. A key ``p`` or ``p_...`` is a p: three decimals, or ``< .001``.
    """

    key: str
    head: str
    factor: float = 1.0
    digits: int = 3
    name: str = ""

    def shown(self, value: Cell) -> str:
        if value is None:
            return UNDEFINED
        if isinstance(value, bool):
            return "yes" if value else "no"
        if isinstance(value, str):
            return value
        if self.key == "p" or self.key.startswith("p_"):
            return " ".join(p_parts(value)).removeprefix("= ")
        return number(value * self.factor if self.factor != 1 else value, self.digits)


@dataclass(frozen=True)
class Table:
    """``rows`` hold plain values, one per column; people see ``shown_rows`` where all would be too many."""

    name: str
    caption: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    shown_rows: tuple[tuple[Cell, ...], ...] | None = None

    def csv(self) -> str:
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow([column.name or column.key for column in self.columns])
        writer.writerows([_exact(value) for value in row] for row in self.rows)
        return text.getvalue()

    def html(self) -> str:
        """Scrolls sideways on a narrow screen."""
        classes = ["n" if numeric else "" for numeric in self.numeric()]
        cell = {"": "<td>", "n": '<td class="n">'}
        heads = "".join(
            f'<th scope="col"{" class=n" if kind else ""}>{escape(column.head)}</th>'
            for column, kind in zip(self.columns, classes, strict=True)
        )
        body = "\n".join(
            "<tr>"
            + "".join(f"{cell[kind]}{escape(text)}</td>" for kind, text in zip(classes, cells, strict=True))
            + "</tr>"
            for cells in self.cells()
        )
        label = escape(self.caption)
        return (
            f'<div class="wide" role="region" tabindex="0" aria-label="{label}"><table><caption>{label}</caption>\n'
            f"<thead><tr>{heads}</tr></thead>\n<tbody>\n{body}\n</tbody></table></div>\n"
        )

    def numeric(self) -> list[bool]:
        """Which columns hold numbers."""
        return [
            any(isinstance(row[i], (int, float)) and not isinstance(row[i], bool) for row in self.rows)
            for i in range(len(self.columns))
        ]

    def cells(self) -> list[list[str]]:
        """What people see."""
        rows = self.rows if self.shown_rows is None else self.shown_rows
        return [[column.shown(value) for column, value in zip(self.columns, row, strict=True)] for row in rows]


def rows_of(*arrays: Sequence[Cell] | np.ndarray) -> tuple[tuple[Cell, ...], ...]:
    """Rows of plain values from columns of equal length."""
    columns = [array.tolist() if isinstance(array, np.ndarray) else list(array) for array in arrays]
    return tuple(zip(*columns, strict=True))


def _exact(value: Cell) -> Cell:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    return repr(value) if isinstance(value, float) else value


def activity_column(key: str, name: str, scale: ActivityScale) -> Column:
    """Column of activities: volts in CSV, ``scale``'s unit for people; without ``_v`` where it is not in volts."""
    return Column(key, scale.label(name), scale.factor, name="" if scale.unit else key.removesuffix("_v"))
