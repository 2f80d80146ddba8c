"""The two kinds of file that stand beside data in BIDS, written whole or not at all: tables, and JSON about them."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from casr.atomic import write_text_atomic
from emg2vsa.errors import DataError

Json = dict[str, Any]
ABSENT = "n/a"


@dataclass(frozen=True)
class Column:
    """What a column holds. levels : its words, and what each means."""

    said: str
    unit: str = ""
    levels: Mapping[str, str] = field(default_factory=dict)


def described(columns: Mapping[str, Column]) -> Json:
    """Columns as the JSON file beside their table explains them."""
    keys = ("Description", "Units", "Levels")
    texts = {name: (column.said, column.unit, dict(column.levels)) for name, column in columns.items()}
    return {name: {key: told for key, told in zip(keys, of, strict=True) if told} for name, of in texts.items()}


def write_json(path: Path, content: Json) -> None:
    write_text_atomic(path, json.dumps(content, indent=2) + "\n")


def write_tsv(path: Path, columns: Iterable[str], rows: Iterable[Sequence[object]], mode: int = 0o644) -> None:
    """A table of BIDS, which has no quotes: tabs and line feeds of a cell become spaces."""
    cells = (
        [re.sub(r"[\t\r\n]+", " ", "" if cell is None else str(cell)) for cell in row]
        for row in (tuple(columns), *rows)
    )
    write_text_atomic(path, "".join("\t".join(row) + "\n" for row in cells), mode=mode)


def read_tsv(path: Path) -> list[list[str]]:
    """Rows that are not empty, the head first. OSError, ValueError : it cannot be read."""
    lines = path.read_text(encoding="utf-8-sig").split("\n")
    return [line.rstrip("\r").split("\t") for line in lines if line.strip("\r")]


def merge_tsv(
    path: Path,
    columns: Sequence[str],
    new: Iterable[Sequence[str]],
    stays: Callable[[str], bool] | None,
    mode: int = 0o644,
) -> None:
    """A table with ``new`` rows by their first cell, beside those of the file that stay, with what else they have;
    columns that the file lacks come last.

    stays : by their first cell; None: no row does. DataError : the file is no such table.
    """
    rows: list[list[str]] = []
    if stays is not None and path.exists():
        try:
            rows = read_tsv(path)
        except (OSError, ValueError) as error:
            found = getattr(error, "strerror", None) or str(error)
            raise DataError(
                path, wanted="a tab-separated table in UTF-8", found=found, do="Correct the file, or move it away."
            ) from error
    head = rows[0] if rows else list(columns)
    if head[0] != columns[0]:
        raise DataError(
            path, wanted=f"columns {', '.join(columns)}, the first of them first", found=", ".join(head),
            do="Correct the table, or move it away.",
        )  # fmt: skip
    head += [column for column in columns if column not in head]
    names = [row[0] for row in rows[1:]]
    if twice := next((name for name in names if names.count(name) > 1), None):
        do = "Remove the row that is wrong."
        raise DataError(path, wanted="one row each", found=f"{twice} twice", do=do)
    kept = {row[0]: row for row in rows[1:] if stays is not None and stays(row[0])}
    for cells in new:
        given = dict(zip(head, kept.get(cells[0], []), strict=False)) | dict(zip(columns, cells, strict=True))
        kept[cells[0]] = [given.get(column, ABSENT) for column in head]
    write_tsv(path, head, ([*row, *[ABSENT] * (len(head) - len(row))] for row in kept.values()), mode)
