"""In which order a participant's recordings were made: by scans.tsv of BIDS, a table order.tsv, or the recordings."""

from __future__ import annotations

import contextlib
import csv
import math
import os
from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path

from emg2vsa.errors import DataError

SCANS, ORDER = "_scans.tsv", "order.tsv"
_TABLES_IN = (Path("derivatives", "truth"), Path())
"""Where in a folder of recordings ``order.tsv`` may lie; a simulation writes it beside its truth."""
_ABSENT = ("", "n/a")

_SCANS, _ORDER = ("filename",), ("participant", "specimen", "order")
"""Columns that they must have."""

Cell = tuple[str, str]
"""Participant and specimen."""


def order_files(recordings: Iterable[Path], data: Path) -> list[Path]:
    """The files that tell the order of ``recordings``, which lie in ``data``; none where nothing was written down."""
    inner = dict.fromkeys(map(os.path.dirname, recordings))
    folders = dict.fromkeys(folder for own in inner for folder in (own, os.path.dirname(own)))
    scans = [Path(folder, name) for folder in folders for name in sorted(_names(folder)) if name.endswith(SCANS)]
    return scans + [path for folder in _TABLES_IN if (path := data / folder / ORDER).is_file()][:1]


def _names(folder: str) -> list[str]:
    """Names in a folder; none where it cannot be listed."""
    with contextlib.suppress(OSError):
        return os.listdir(folder or os.curdir)
    return []


def places(
    recordings: Mapping[Cell, Path], files: Sequence[Path], began: Mapping[Cell, str] | None = None
) -> dict[Cell, float]:
    """Place of every recording in the order of its participant, from 1, NaN where not all of these are known.

    files : as ``order_files`` gives them. began : when each recording began, as its file states it. The times of
    scans.tsv count before ``order.tsv``, and this before what recordings state. Recordings of the same time have no
    order. DataError : a table cannot be read, or states what is no time or place.
    """
    times: dict[Path, float] = {}
    stated: dict[Cell, float] = {}
    for file in files:
        if file.name == ORDER:
            stated = {(row["participant"], row["specimen"]): _place(file, row["order"]) for row in _rows(file, _ORDER)}
        else:
            times |= {(file.parent / row["filename"]).absolute(): _time(file, row) for row in _rows(file, _SCANS)}
    found: dict[Cell, float] = {}
    for participant in dict.fromkeys(participant for participant, _ in recordings):
        own = [cell for cell in recordings if cell[0] == participant]
        by_time = _ranks([times.get(recordings[cell].absolute(), math.nan) for cell in own])
        ranks = by_time or _ranks([stated.get(cell, math.nan) for cell in own])
        ranks = ranks or _ranks([_seconds((began or {}).get(cell, "")) for cell in own])
        found |= dict(zip(own, ranks or [math.nan] * len(own), strict=True))
    return found


def _ranks(values: Sequence[float]) -> list[float]:
    """Ranks from 1; none where a value is unknown or occurs twice."""
    known = sorted(value for value in values if value == value)
    if len(set(known)) < len(values):
        return []
    return [known.index(value) + 1.0 for value in values]


def _rows(file: Path, columns: Sequence[str]) -> list[dict[str, str]]:
    try:
        with file.open(encoding="utf-8-sig", newline="") as lines:
            table = csv.DictReader(lines, delimiter="\t")
            head = table.fieldnames or ()
            rows = [{key: value or "" for key, value in row.items() if key} for row in table]
    except (OSError, ValueError, csv.Error) as error:
        raise DataError(
            file, wanted="a tab-separated table in UTF-8", found=str(error), do="Correct the file, or move it away."
        ) from error
    if not set(columns) <= set(head):
        raise DataError(
            file, wanted=f"columns {', '.join(columns)}, with tabs between them",
            found=", ".join(map(repr, head)) or "an empty file", do="Correct the table, or move it away.",
        )  # fmt: skip
    named = [tuple(row[column] for column in columns[:2]) for row in rows]
    if twice := next((name for name in named if named.count(name) > 1), None):
        raise DataError(
            file, wanted="one row for each recording", found=f"{' '.join(twice)} more than once", do="Keep one of them."
        )
    return rows


def _time(file: Path, row: Mapping[str, str]) -> float:
    """Seconds; NaN where the table does not say."""
    text = row.get("acq_time", "")
    if text in _ABSENT:
        return math.nan
    seconds = _seconds(text)
    if seconds != seconds:
        raise DataError(
            f"{file}, acq_time of {row['filename']}", wanted="a date and time, such as 2026-01-06T09:05:00, or n/a",
            found=repr(text), do="Correct this cell.",
        )  # fmt: skip
    return seconds


def _seconds(text: str) -> float:
    """Since 1970, of a date and time by ISO 8601; NaN of any other text."""
    try:
        time = datetime.fromisoformat(text)
    except ValueError:
        return math.nan
    return (time if time.tzinfo else time.replace(tzinfo=UTC)).timestamp()


def _place(file: Path, text: str) -> float:
    try:
        place = math.nan if text in _ABSENT else float(text)
    except ValueError:
        place = math.inf
    if math.isinf(place):
        raise DataError(f"{file}, order", wanted="a number, or n/a", found=repr(text), do="Correct this cell.")
    return place
