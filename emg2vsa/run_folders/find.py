"""Which runs a folder holds."""

from __future__ import annotations

import csv
import json
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import get_args

from casr.by_name import module_named
from casr.errors import CasrError
from emg2vsa.errors import DataError
from emg2vsa.rig.record.new_folder import EMULATED_FILE, KAPPA_ABOUT_FILE, PLAN_FILE
from emg2vsa.settings import Condition
from emg2vsa.study import RunEntry

RUNS_TABLE = "runs.tsv"
_COLUMNS = ("folder", "specimen", "angle_deg", "condition")
_ORDER = "order"
_NEAR = 0.85
"""Names at least so alike are taken for one misspelt: "modularr", not "constant" for "constant-min"."""


@dataclass(frozen=True)
class _Found:
    """A folder of presses, and the ``where`` that says what it is."""

    where: str
    folder: Path
    specimen: str
    angle_deg: float
    condition: str
    order: float | None = None


def find_runs(root: Path, specimens: Collection[str]) -> tuple[RunEntry, ...]:
    """Runs below ``root``: those that its table runs.tsv lists, or without one the folders that hold a plan.json.

    Folders of the same specimen, angle and condition are one run, their presses one after the other. The column
    ``order`` of the table is its own choice. specimens : those
    that may have been pressed. Without a table, runs of another specimen whose stiffness was judged while it was
    pressed are no runs of the study, so ``left_out`` names them.

    Raises
    ------
    DataError : a table or plan that makes no sense, naming its line or key; another specimen; a condition spelt nearly
    as a standard one; a folder listed twice.
    """
    table = root / RUNS_TABLE
    rows = list(_listed(table) if table.is_file() else _planned(root))
    _check_folders(rows)
    _check_order(rows)
    runs: dict[tuple[str, float, str], list[_Found]] = {}
    for row in rows:
        if row.specimen not in specimens and was_judged(row.folder) and not table.is_file():
            continue
        _check_names(row, specimens)
        runs.setdefault((row.specimen, row.angle_deg, row.condition), []).append(row)
    return tuple(
        RunEntry(*of_run, tuple(row.folder for row in own), tuple(row.order for row in own if row.order is not None))
        for of_run, own in runs.items()
    )


def left_out(root: Path, runs: Sequence[RunEntry]) -> tuple[str, ...]:
    """Names of the folders in ``root`` that hold frames, but are of no run."""
    taken = [folder for run in runs for folder in run.folders]
    others = [path for path in _folders_in(root) if not any(_overlap(path, folder) for folder in taken)]
    return tuple(path.name for path in others if _holds_frames(path))


def was_judged(folder: Path) -> bool:
    """The run was of an unknown object: its stiffness was what the presses were for."""
    return (folder / KAPPA_ABOUT_FILE).is_file()


def left_by_emulator(root: Path) -> tuple[Path, ...]:
    """Folders in ``root`` of runs that an emulated rig made, in the order of their names; none where there is no root.

    Version 0.1.0 recorded emulated runs where those of a real rig go. They hold emulated.json and plan.json.
    """
    return tuple(path.parent for path in sorted(root.glob(f"*/{EMULATED_FILE}")) if (path.parent / PLAN_FILE).is_file())


def _folders_in(root: Path) -> list[Path]:
    return sorted(path for path in root.glob("[!.]*") if path.is_dir())


def _overlap(one: Path, other: Path) -> bool:
    return one.is_relative_to(other) or other.is_relative_to(one)


def _holds_frames(folder: Path) -> bool:
    # what opens frames is loaded for the folders in question alone: most tables list them all
    try:
        return bool(module_named("casr.frame_files").find_presses(folder))
    except CasrError:
        return False


def _listed(table: Path) -> Iterator[_Found]:
    try:
        text = table.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise _unusable(table, "a table of runs", str(error)) from error
    reader = csv.DictReader(text.splitlines(), delimiter="\t")
    missing = [name for name in _COLUMNS if name not in (reader.fieldnames or ())]
    if missing:
        found = ", ".join(reader.fieldnames or ()) or "no header line"
        raise _unusable(table, f"tab-separated columns {', '.join(_COLUMNS)}", found)
    if near := [n for n in reader.fieldnames or () if n != _ORDER and n.strip().casefold() == _ORDER]:
        raise _unusable(f"{table}, header", f"the column {_ORDER} so spelt", repr(near[0]))
    for row in reader:
        yield _row(f"{table}, line {reader.line_num}", table.parent, row)


def _row(where: str, root: Path, row: dict[str, str | None]) -> _Found:
    empty = [name for name in _COLUMNS if not (row[name] or "").strip()]
    if empty:
        raise _unusable(where, f"a value for {', '.join(empty)}", "nothing")
    folder, specimen, angle, condition = ((row[name] or "").strip() for name in _COLUMNS)
    if not (root / folder).is_dir():
        raise _unusable(f"{where}, folder", "a folder beside the table", repr(folder))
    order = _order(f"{where}, {_ORDER}", row[_ORDER]) if _ORDER in row else None
    return _Found(where, root / folder, specimen, _angle(f"{where}, angle_deg", angle), condition, order)


def _order(where: str, value: str | None) -> float:
    try:
        order = int(value or "")
    except ValueError:
        order = 0
    if order < 1:
        raise _unusable(where, "a whole number from 1, the place in which it was recorded", repr(value or ""))
    return float(order)


def _planned(root: Path) -> Iterator[_Found]:
    for path in sorted(root.glob(f"*/{PLAN_FILE}")):
        try:
            plan = json.loads(path.read_text(encoding="utf-8"))["plan"]
            specimen, angle, condition = str(plan["specimen"]), plan["angle_deg"], str(plan["condition"])
        except (OSError, ValueError, TypeError, KeyError) as error:
            found = f"{type(error).__name__}: {error}"
            raise _unusable(path, "a plan with specimen, angle_deg and condition", found) from error
        yield _Found(str(path), path.parent, specimen, _angle(f"{path}, angle_deg", angle), condition)


def _angle(where: str, value: object) -> float:
    try:
        angle_deg = float(str(value))
    except ValueError:
        angle_deg = -1.0
    if not 0 <= angle_deg < 90:
        raise _unusable(where, "0 to below 90 degrees", repr(value))
    return angle_deg


def _check_folders(rows: Sequence[_Found]) -> None:
    """No press is counted twice."""
    seen: list[tuple[Path, _Found]] = []
    for row in rows:
        folder = row.folder.resolve()
        for other, earlier in seen:
            if _overlap(folder, other):
                found = f"{row.folder.name!r}, whose presses {earlier.where.rpartition(', ')[2]} has already"
                raise _unusable(f"{row.where}, folder", "every folder once", found)
        seen.append((folder, row))


def _check_order(rows: Sequence[_Found]) -> None:
    seen: dict[float, _Found] = {}
    for row in rows:
        if row.order is not None and seen.setdefault(row.order, row) is not row:
            found = f"{row.order:g}, which {seen[row.order].where.rpartition(', ')[2]} has already"
            raise _unusable(f"{row.where}, {_ORDER}", "every place once", found)


def _check_names(row: _Found, specimens: Collection[str]) -> None:
    if row.specimen not in specimens:
        known = ", ".join(specimens) or "none"
        near = _nearest(row.specimen, specimens)
        raise DataError(
            f"{row.where}, specimen",
            wanted=f"a specimen whose stiffness the study file gives ({known})",
            found=repr(row.specimen),
            do=f"Did you mean {near!r}?" if near else "Mend it, or give its stiffness under [[specimens]].",
        )
    near = _nearest(row.condition, get_args(Condition))
    if near and near != row.condition:
        raise DataError(
            f"{row.where}, condition",
            wanted=f"one of {', '.join(get_args(Condition))}, or a name unlike them",
            found=repr(row.condition),
            do=f"Did you mean {near!r}?",
        )


def _nearest(name: str, known: Collection[str]) -> str:
    """The known name that ``name`` is, but for a slip of the keys, case, or what joins its words."""
    plain = {_plain(other): other for other in known}
    from difflib import get_close_matches  # a folder of runs with known names does without it

    near = get_close_matches(_plain(name), plain, n=1, cutoff=_NEAR)
    return plain[near[0]] if near else ""


def _plain(name: str) -> str:
    return name.casefold().replace("_", "-").replace(" ", "-")


def _unusable(where: object, wanted: str, found: str) -> DataError:
    do = "Mend it; docs/how-to/measured-runs.md shows one."
    return DataError(where, wanted=wanted, found=found, do=do)


def plate_logs(folder: Path) -> list[Path]:
    """Plate indentations in ``folder``: what ``rig run --plate`` wrote there, and tables (.csv)."""
    found = sorted(folder.glob("[!.]*"))
    return [path for path in found if (path / PLAN_FILE).is_file() or (path.suffix == ".csv" and path.is_file())]
