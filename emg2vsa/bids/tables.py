"""The two kinds of file that stand beside data in BIDS, written whole or not at all: tables, and JSON about them."""

from __future__ import annotations

import csv
import io
import json
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


def write_tsv(path: Path, columns: Iterable[str], rows: Iterable[Sequence[object]]) -> None:
    buffer = io.StringIO()
    csv.writer(buffer, delimiter="\t", lineterminator="\n").writerows([tuple(columns), *rows])
    write_text_atomic(path, buffer.getvalue())


def merge_tsv(
    path: Path, columns: Sequence[str], new: Iterable[Sequence[str]], stays: Callable[[str], bool] | None
) -> None:
    """A table with ``new`` rows by their first cell, beside those of the file that stay, with what else they have;
    columns that the file lacks come last.

    stays : by their first cell; None: no row does. DataError : the file is no such table.
    """
    rows: list[list[str]] = []
    if stays is not None and path.exists():
        try:
            with path.open(encoding="utf-8-sig", newline="") as lines:
                rows = [row for row in csv.reader(lines, delimiter="\t") if row]
        except (ValueError, csv.Error) as error:
            raise DataError(
                path, wanted="a tab-separated table in UTF-8", found=str(error), do="Correct the file, or move it away."
            ) from error
    head = rows[0] if rows else list(columns)
    if head[0] != columns[0]:
        raise DataError(
            path, wanted=f"columns {', '.join(columns)}, the first of them first", found=", ".join(head),
            do="Correct the table, or move it away.",
        )  # fmt: skip
    head += [column for column in columns if column not in head]
    kept = {row[0]: row for row in rows[1:] if stays is not None and stays(row[0])}
    for cells in new:
        given = dict(zip(head, kept.get(cells[0], []), strict=False)) | dict(zip(columns, cells, strict=True))
        kept[cells[0]] = [given.get(column, ABSENT) for column in head]
    write_tsv(path, head, ([*row, *[ABSENT] * (len(head) - len(row))] for row in kept.values()))
