"""Which runs a folder holds."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator
from pathlib import Path

from emg2vsa.errors import DataError
from emg2vsa.study import RunEntry

RUNS_TABLE = "runs.tsv"
PLAN_FILE = "plan.json"
_COLUMNS = ("folder", "specimen", "angle_deg", "condition")


def find_runs(root: Path) -> tuple[RunEntry, ...]:
    """Runs below ``root``: those that its table runs.tsv lists, or without one the folders that hold a plan.json.

    Folders of the same specimen, angle and condition are one run, their presses one after the other.

    Raises
    ------
    DataError : a table or plan that makes no sense, naming its line or key.
    """
    table = root / RUNS_TABLE
    rows = _listed(table) if table.is_file() else _planned(root)
    runs: dict[tuple[str, float, str], list[Path]] = {}
    for folder, *of_run in rows:
        runs.setdefault(tuple(of_run), []).append(folder)  # type: ignore[arg-type]
    return tuple(RunEntry(*of_run, tuple(folders)) for of_run, folders in runs.items())


Found = tuple[Path, str, float, str]


def _listed(table: Path) -> Iterator[Found]:
    try:
        text = table.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise _unusable(table, "a table of runs", str(error)) from error
    reader = csv.DictReader(text.splitlines(), delimiter="\t")
    missing = [name for name in _COLUMNS if name not in (reader.fieldnames or ())]
    if missing:
        found = ", ".join(reader.fieldnames or ()) or "no header line"
        raise _unusable(table, f"tab-separated columns {', '.join(_COLUMNS)}", found)
    for row in reader:
        yield _row(f"{table}, line {reader.line_num}", table.parent, row)


def _row(where: str, root: Path, row: dict[str, str | None]) -> Found:
    empty = [name for name in _COLUMNS if not (row[name] or "").strip()]
    if empty:
        raise _unusable(where, f"a value for {', '.join(empty)}", "nothing")
    folder, specimen, angle, condition = ((row[name] or "").strip() for name in _COLUMNS)
    if not (root / folder).is_dir():
        raise _unusable(f"{where}, folder", "a folder beside the table", repr(folder))
    return root / folder, specimen, _angle(f"{where}, angle_deg", angle), condition


def _planned(root: Path) -> Iterator[Found]:
    for path in sorted(root.glob(f"*/{PLAN_FILE}")):
        try:
            plan = json.loads(path.read_text(encoding="utf-8"))["plan"]
            specimen, angle, condition = str(plan["specimen"]), plan["angle_deg"], str(plan["condition"])
        except (OSError, ValueError, TypeError, KeyError) as error:
            found = f"{type(error).__name__}: {error}"
            raise _unusable(path, "a plan with specimen, angle_deg and condition", found) from error
        yield path.parent, specimen, _angle(f"{path}, angle_deg", angle), condition


def _angle(where: str, value: object) -> float:
    try:
        angle_deg = float(str(value))
    except ValueError:
        angle_deg = -1.0
    if not 0 <= angle_deg < 90:
        raise _unusable(where, "0 to below 90 degrees", repr(value))
    return angle_deg


def _unusable(where: object, wanted: str, found: str) -> DataError:
    do = "Mend it; docs/how-to/measured-runs.md shows one."
    return DataError(where, wanted=wanted, found=found, do=do)
