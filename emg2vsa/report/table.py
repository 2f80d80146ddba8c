"""One table: what programs read of it (CSV, every digit) and what people see (rounded, here as HTML)."""

from __future__ import annotations

import csv
import io
import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np

from casr import html
from emg2vsa.figures.palette import ActivityScale
from emg2vsa.report.wording import UNDEFINED, number, p_value, typeset
from emg2vsa.shown import words_of

Cell = str | int | float | bool | None
Row = Mapping[str, Cell]
MOST_ON_PAGE, FEW_ON_PAGE = 200, 20
"""Rows of a table that people see on a page, and of one on single persons or pairs; the others are in its file."""
_AT_ONCE = 500


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
            return value if self.key == "latex" else typeset(value)
        if self.key == "p" or self.key.startswith("p_"):
            return p_value(value)
        return number(value * self.factor if self.factor != 1 else value, self.digits)


Values = Sequence[Cell] | np.ndarray
Columns = dict[Column, Values]
"""Values (n,) of each column of a table."""


@dataclass(frozen=True)
class Table:
    """``rows`` map the key of every column to a plain value; people see ``shown_rows`` where all would be too many.

    ValueError : a row lacks a column, or has a key that is none. kinds : CSS classes of the rows that people see, as
    many as these. links : addresses of their first cells. groups : a heading of each; neighbours share theirs. most :
    rows that the page of the report shows.
    """

    name: str
    caption: str
    columns: tuple[Column, ...]
    rows: Sequence[Row]
    shown_rows: tuple[Row, ...] | None = None
    kinds: tuple[str, ...] = ()
    links: tuple[str, ...] = ()
    groups: tuple[str, ...] = ()
    most: int = MOST_ON_PAGE

    def __post_init__(self) -> None:
        keys = [column.key for column in self.columns]
        for row in itertools.chain(self.rows, self.shown_rows or ()):
            if row.keys() != set(keys):
                raise ValueError(f"table {self.name}: a row has {sorted(row)}, the columns are {sorted(keys)}")

    def csv(self) -> Iterator[str]:
        """Pieces of the file, some hundred rows each."""
        rows = iter(self.rows)
        lines: list[list[Cell]] = [[column.name or column.key for column in self.columns]]
        while lines:
            text = io.StringIO()
            csv.writer(text, lineterminator="\n").writerows(lines)
            yield text.getvalue()
            some = itertools.islice(rows, _AT_ONCE)
            lines = [["" if (value := row[c.key]) != value else value for c in self.columns] for row in some]

    def html(self, number: int = 0, *, whole: bool = False) -> str:
        """Scrolls sideways on a narrow screen. number : of the table on its page. whole : every row."""
        most = None if whole else self.most
        classes = [
            "verdict" if column.key == "verdict" else "n" if numeric else ""
            for column, numeric in zip(self.columns, self.numeric(), strict=True)
        ]
        table = html.table(
            typeset(self.caption), [column.head for column in self.columns], self.cells(most), self.links,
            number=number, classes=classes, kinds=self.kinds, groups=self.groups,
        )  # fmt: skip
        n, file = len(self._seen), escape(self.own_page or f"tables/{self.name}.csv")
        if most is None or n <= most:
            return table
        return f'{table}<p class="small">The first {most} of {n} rows. All rows: <a href="{file}">{file}</a>.</p>\n'

    @property
    def own_page(self) -> str:
        """Name of the page that shows all rows; "" where the report's page does, or no row has a link."""
        return f"{self.name}.html" if self.links and len(self.rows) > self.most else ""

    def numeric(self) -> list[bool]:
        """Which columns hold numbers."""
        return [
            any(isinstance(row[c.key], (int, float)) and not isinstance(row[c.key], bool) for row in self.rows)
            for c in self.columns
        ]

    def cells(self, most: int | None = None) -> list[list[str]]:
        """What people see, of so many rows at ``most``."""
        rows = itertools.islice(self._seen, most)
        return [[column.shown(row[column.key]) for column in self.columns] for row in rows]

    @property
    def _seen(self) -> Sequence[Row]:
        return self.rows if self.shown_rows is None else self.shown_rows


class ColumnRows(Sequence[Row]):
    """Rows of plain values from columns of equal length, made when they are asked for.

    A dict for each row of a study of a thousand people would take a hundred megabytes.
    """

    def __init__(self, columns: Mapping[str, Values]) -> None:
        self._columns = dict(columns)
        lengths = {key: len(values) for key, values in columns.items()}
        if len(set(lengths.values())) > 1:
            raise ValueError(f"columns of unequal length: {lengths}")
        self._length = next(iter(lengths.values()), 0)

    def __len__(self) -> int:
        return self._length

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice):
            return list(self._some(index))
        at = range(self._length)[index]
        return next(self._some(slice(at, at + 1)))

    def __iter__(self) -> Iterator[Row]:
        for first in range(0, self._length, _AT_ONCE):
            yield from self._some(slice(first, first + _AT_ONCE))

    def _some(self, which: slice) -> Iterator[Row]:
        parts = (values[which] for values in self._columns.values())
        lists = [part.tolist() if isinstance(part, np.ndarray) else list(part) for part in parts]
        return (dict(zip(self._columns, values, strict=True)) for values in zip(*lists, strict=True))


def table_of(name: str, caption: str, columns: Mapping[Column, Values], most: int = MOST_ON_PAGE) -> Table:
    """A table from the values (n,) of each of its columns."""
    rows = ColumnRows({column.key: values for column, values in columns.items()})
    return Table(name, caption, tuple(columns), rows, most=most)


def columns(found: object, *keys: str, at: Any = slice(None)) -> Columns:
    """Those fields of a dataclass that declare how people read them, as columns. at : which of their values.

    KeyError : a field declares nothing.
    """
    words = words_of(found)
    return {Column(key, *words[key]): getattr(found, key)[at] for key in keys}


def from_quantities(q: Mapping[str, Cell], names: Sequence[str], keys: Mapping[Column, str]) -> Columns:
    """Columns of quantities ``name.key``, one row for each of the ``names``; None where there is none."""
    return {column: [q.get(f"{name}.{key}") for name in names] for column, key in keys.items()}


def records(objects: Iterable[object], columns: Sequence[Column]) -> tuple[Row, ...]:
    """Rows from objects that have an attribute for each key."""
    return tuple({column.key: getattr(each, column.key) for column in columns} for each in objects)


def activity_column(key: str, name: str, scale: ActivityScale) -> Column:
    """Column of activities: volts in CSV, ``scale``'s unit for people; without ``_v`` where it is not in volts."""
    return Column(key, scale.label(name), scale.factor, name="" if scale.unit else key.removesuffix("_v"))
