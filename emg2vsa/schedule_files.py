"""Schedules as CSV and JSON files: the same content in both, read back exactly, refused when it was changed.

CSV: comment lines ``# key: JSON value`` (format, version, specimen, condition, last_step_short, ramp, limits,
provenance, sha256), a header row, and one row per force step. JSON: one object with the same keys and ``steps``, a list
of the same rows. Numbers are the shortest text that reads back as the same double. ``sha256`` is that of the rest.
"""

from __future__ import annotations

import csv
import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from casr.atomic import write_text_atomic
from emg2vsa.errors import ScheduleError
from emg2vsa.schedules import Schedule, check
from emg2vsa.schedules.checks import EXPORT_AGAIN
from emg2vsa.schedules.document import Columns, Document, columns_of, document_of, export_in, schedule_of


def write_schedule(folder: Path, schedule: Schedule) -> tuple[Path, Path]:
    """Write ``<specimen>_<condition>.csv`` and ``.json`` into ``folder``; their paths. ScheduleError as ``check``."""
    stem = f"{schedule.specimen}_{schedule.condition}"
    if any(c in stem for c in '/\\:*?"<>|\0') or stem.startswith("."):
        raise ScheduleError(
            "specimen",
            wanted="a name that can be part of a file name",
            found=repr(schedule.specimen),
            do="Rename the specimen.",
        )
    paths = folder / f"{stem}.csv", folder / f"{stem}.json"
    write_csv(paths[0], schedule)
    write_json(paths[1], schedule)
    return paths


def write_csv(path: Path, schedule: Schedule) -> None:
    """Write one schedule, atomically, after ``check``."""
    document = _sealed(schedule)
    steps = document.pop("steps")
    lines = [f"# {key}: {json.dumps(value)}" for key, value in document.items()]
    columns = columns_of(schedule.limits.export, document["version"])
    lines.append(",".join(columns))
    lines.extend(",".join(repr(row[column]) for column in columns) for row in steps)
    write_text_atomic(path, "\n".join(lines) + "\n")


def write_json(path: Path, schedule: Schedule) -> None:
    """Write one schedule, atomically, after ``check``."""
    write_text_atomic(path, json.dumps(_sealed(schedule), indent=1, allow_nan=False) + "\n")


def read_csv(path: Path) -> Schedule:
    """What ``write_csv`` wrote; ScheduleError naming file, row and column otherwise."""
    return _opened(path, _parse_csv)


def read_json(path: Path) -> Schedule:
    """What ``write_json`` wrote; ScheduleError naming file, row and column otherwise."""
    return _opened(path, _parse_json)


def _sealed(schedule: Schedule) -> Document:
    check(schedule)
    document = document_of(schedule)
    steps = document.pop("steps")
    return {**document, "sha256": _digest(schedule), "steps": steps}


def _digest(schedule: Schedule) -> str:
    text = json.dumps(document_of(schedule), sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def _opened(path: Path, parse: Callable[[str, Path], Document]) -> Schedule:
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        found = error.strerror if isinstance(error, OSError) else "bytes that are not text"
        raise ScheduleError(path, wanted="a schedule file", found=str(found), do=EXPORT_AGAIN) from error
    document = parse(text, path)
    seal = document.pop("sha256", None)
    schedule = schedule_of(document, str(path))
    check(schedule, str(path), EXPORT_AGAIN)
    if seal != _digest(schedule):
        raise ScheduleError(f"{path}, sha256", wanted="the digest of the content", found=repr(seal), do=EXPORT_AGAIN)
    return schedule


def _parse_json(text: str, path: Path) -> Document:
    try:
        document = json.loads(text, object_pairs_hook=lambda pairs: _once(pairs, path))
    except (ValueError, RecursionError) as error:
        raise ScheduleError(path, wanted="a JSON object", found=str(error), do=EXPORT_AGAIN) from error
    if not isinstance(document, dict):
        raise ScheduleError(path, wanted="a JSON object", found=type(document).__name__, do=EXPORT_AGAIN)
    return document


def _once(pairs: list[tuple[str, Any]], path: Path) -> Document:
    """An object of JSON, whose keys stand once: of two values for one key a reader cannot know which was meant."""
    document = dict(pairs)
    if len(document) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ScheduleError(f"{path}, {twice}", wanted="every key once", found="one key twice", do=EXPORT_AGAIN)
    return document


def _parse_csv(text: str, path: Path) -> Document:
    lines = text.splitlines()
    head = [line for line in lines if line.startswith("#")]
    rows = list(csv.reader(line for line in lines if line and not line.startswith("#")))
    document = dict(_comment(line, path) for line in head)
    columns = columns_of(export_in(document, str(path)), document.get("version"))
    if not rows or rows[0] != list(columns):
        found = ",".join(rows[0]) if rows else "no header row"
        raise ScheduleError(f"{path}, header row", wanted=",".join(columns), found=found, do=EXPORT_AGAIN)
    document["steps"] = [
        _cells(cells, columns, f"{path}, row {number}") for number, cells in enumerate(rows[1:], start=1)
    ]
    return document


def _comment(line: str, path: Path) -> tuple[str, Any]:
    key, _, value = line.removeprefix("#").partition(":")
    try:
        return key.strip(), json.loads(value)
    except (ValueError, RecursionError) as error:
        raise ScheduleError(
            f"{path}, {key.strip()}", wanted="a JSON value", found=value.strip(), do=EXPORT_AGAIN
        ) from error


def _cells(cells: list[str], columns: Columns, where: str) -> dict[str, int | float]:
    if len(cells) != len(columns):
        raise ScheduleError(where, wanted=f"{len(columns)} values", found=f"{len(cells)}", do=EXPORT_AGAIN)
    row: dict[str, int | float] = {}
    for (column, kind), cell in zip(columns.items(), cells, strict=True):
        try:
            row[column] = kind(cell)
        except ValueError as error:
            wanted = "a whole number" if kind is int else "a number"
            raise ScheduleError(
                f"{where}, column {column}", wanted=wanted, found=repr(cell), do=EXPORT_AGAIN
            ) from error
    return row
