"""The rig file: TOML in, a checked ``RigFile`` out, or every problem at once with its line."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import MISSING, fields, replace
from pathlib import Path
from types import NoneType
from typing import Any, get_args, get_type_hints

from emg2vsa.rig.device_settings import DeviceSettings
from emg2vsa.rig.experiment import ExperimentSettings
from emg2vsa.rig_file.checks import problems_across
from emg2vsa.rig_file.rig_file import RigFile
from emg2vsa.rig_file.tables import RigTables
from emg2vsa.study_file.entries import beside
from emg2vsa.study_file.problems import Problem, checked, unknown_key
from emg2vsa.study_file.toml_file import placed, read_toml

__all__ = ["RigFile", "load_rig"]


def load_rig(path: str | Path) -> RigFile:
    """The rig in a TOML file. Relative paths in it are resolved against its folder; no file need exist.

    Raises
    ------
    StudyError
        Lists every problem as ``file:line: key: wanted ...; found ...``: TOML syntax, unknown keys, wrong types,
        values out of range, missing keys, and keys that contradict each other.
    """
    path = Path(path)
    text, raw = read_toml(path, "a rig file")
    tables, problems = _tables(raw)
    faulty = {problem.path for problem in problems}
    problems += [problem for problem in problems_across(tables, raw) if not _within(problem.path, faulty)]
    if problems:
        raise placed(path, text, problems)
    return _rig_file(Path(os.path.abspath(path)), RigTables(**tables))


def _tables(raw: Mapping[str, Any]) -> tuple[dict[str, Any], list[Problem]]:
    """Every table on its own, so that one that is faulty hides no problem of another."""
    kinds, tables = get_type_hints(RigTables), {}
    problems = [unknown_key(RigTables, (key,), (), RigTables) for key in raw if key not in kinds]
    for each in fields(RigTables):
        if each.name in raw:
            tables[each.name], found = checked(_table(kinds[each.name]), raw[each.name], (each.name,), RigTables)
            problems += found
        elif each.default_factory is not MISSING:
            tables[each.name] = each.default_factory()
        elif each.default is MISSING:
            problems.append(Problem((each.name,), f"a table [{each.name}]", "nothing"))
    return tables, problems


def _table(kind: Any) -> Any:
    """``kind`` of a table that may be omitted, without the None."""
    return next((part for part in get_args(kind) if part is not NoneType), kind)


def _within(path: tuple[str | int, ...], faulty: set[tuple[str | int, ...]]) -> bool:
    return any(path[: len(other)] == other or other[: len(path)] == path for other in faulty)


def _rig_file(path: Path, tables: RigTables) -> RigFile:
    folder, force = path.parent, tables.force
    if force.cal_file:
        force = replace(force, cal_file=str(beside(folder, force.cal_file)))
    experiment = {each.name: getattr(tables.experiment, each.name) for each in fields(ExperimentSettings)}
    return RigFile(
        path=path,
        rig=tables.rig,
        devices=DeviceSettings(actuator=tables.actuator, motor=tables.motor, force=force, camera=tables.camera),
        experiment=ExperimentSettings(**experiment),
        schedules=beside(folder, tables.experiment.schedules or f"../../reports/{folder.name}/schedules"),
        runs=beside(folder, tables.experiment.runs),
        emulated=tables.emulated,
    )
