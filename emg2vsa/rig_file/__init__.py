"""The rig file: TOML in, a checked ``RigFile`` out, or every problem at once with its line."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from emg2vsa.devices.qbmove import QbmoveSettings
from emg2vsa.rig.experiment import ExperimentSettings
from emg2vsa.rig.rig_settings import DeviceSettings
from emg2vsa.rig_file.checks import problems_across
from emg2vsa.rig_file.older_keys import with_todays_keys
from emg2vsa.rig_file.tables import RigFile, RigTables
from emg2vsa.study_file.problems import checked_tables
from emg2vsa.study_file.toml_file import beside, placed, read_toml, reports_beside
from emg2vsa.worlds.bench.controls import controlled, counterparts

__all__ = ["RigFile", "load_rig"]


def load_rig(path: str | Path) -> RigFile:
    """The rig in a TOML file. Relative paths in it are resolved against its folder; no file need exist.

    Raises
    ------
    StudyError
        Lists every problem as ``file:line: key: expected ..., but found ...``: TOML syntax, unknown keys, wrong types,
        values out of range, missing keys, and keys that contradict each other.
    """
    path = Path(path)
    text, written = read_toml(path, "a rig file")
    today = with_todays_keys(written)
    raw = today.tables
    tables, problems = checked_tables(RigTables, raw)
    faulty = {problem.path for problem in problems}
    problems += [problem for problem in problems_across(tables, raw) if not _within(problem.path, faulty)]
    if problems := [*today.problems, *map(today.placed, problems)]:
        raise placed(path, text, problems)
    return _rig_file(Path(os.path.abspath(path)), RigTables(**tables), raw)


def _within(path: tuple[str | int, ...], faulty: set[tuple[str | int, ...]]) -> bool:
    return any(path[: len(other)] == other or other[: len(path)] == path for other in faulty)


def _rig_file(path: Path, tables: RigTables, raw: Mapping[str, Any]) -> RigFile:
    folder, force = path.parent, tables.force
    if cal_file := getattr(force, "cal_file", None):  # of whatever kind
        force = replace(force, cal_file=str(beside(folder, cal_file)))  # type: ignore[call-arg]
    schedules, rig = tables.experiment.schedules, tables.rig
    if (full_preset := tables.actuator.full_preset) is not None:
        rig = replace(rig, full_preset=full_preset)
    experiment = {each.name: getattr(tables.experiment, each.name) for each in fields(ExperimentSettings)}
    settings, emulated = ExperimentSettings(**experiment), tables.emulated and controlled(tables.emulated)
    if emulated and "springs" not in raw["emulated"] and isinstance(tables.actuator, QbmoveSettings):
        emulated = replace(emulated, springs=tables.actuator.joint)  # type: ignore[arg-type]
    if emulated and emulated.domes:
        emulated = replace(emulated, domes=str(beside(folder, emulated.domes)))
    if emulated and emulated.control == "N3":
        swapped = counterparts(settings.specimens, emulated.stiffness_n_per_mm)
        settings = replace(settings, schedule_of=swapped)
    return RigFile(
        path=path,
        rig=rig,
        devices=DeviceSettings(actuator=tables.actuator, motor=tables.motor, force=force, camera=tables.camera),
        experiment=settings,
        schedules=beside(folder, schedules) if schedules else reports_beside(folder, folder.name) / "schedules",
        runs=beside(folder, tables.experiment.runs),
        emulated=emulated,
        plate=tables.plate,
    )
