"""The study file: TOML in, a checked ``Study`` out, or every problem at once with its line."""

from __future__ import annotations

import os
from dataclasses import fields
from pathlib import Path

from emg2vsa.settings import RunSettings
from emg2vsa.study import RecordingEntry, RunsSource, Specimen, Study
from emg2vsa.study_file.check_names import name_problems
from emg2vsa.study_file.check_recordings import recording_problems
from emg2vsa.study_file.check_stages import stage_problems
from emg2vsa.study_file.draft import Draft, read_draft
from emg2vsa.study_file.entries import beside, data_folder, entries
from emg2vsa.study_file.problems import Problem
from emg2vsa.study_file.schema import json_schema
from emg2vsa.study_file.tables import RunsTable
from emg2vsa.study_file.toml_file import placed, read_toml

__all__ = ["json_schema", "load_study", "missing_files"]


def load_study(path: str | Path) -> Study:
    """The study in a TOML file.

    Relative paths in the file are resolved against its folder. Data files need not exist: see ``missing_files``.

    Raises
    ------
    StudyError
        Lists every problem as ``file:line: key: wanted ...; found ...``: TOML syntax, unknown keys, wrong types,
        values out of range, missing keys, and keys that contradict each other.
    """
    path = Path(path)
    text, raw = read_toml(path, "a study file")
    draft = read_draft(raw, Path(os.path.abspath(path)).parent)
    problems = _all_problems(draft)
    if problems:
        raise placed(path, text, problems)
    return _study(path, draft)


def missing_files(study: Study) -> tuple[RecordingEntry, ...]:
    """The recordings whose EMG or force file is not there."""
    return tuple(
        r for r in study.recordings if not r.emg_file.is_file() or (r.force_file and not r.force_file.is_file())
    )


def _all_problems(draft: Draft) -> list[Problem]:
    """Those of single keys, then those across keys, except where a key is faulty anyway."""
    found = list(draft.problems)
    faulty = {problem.path for problem in found}
    for check in (name_problems, recording_problems, stage_problems):
        for problem in check(draft):
            if not any(
                problem.path[: len(path)] == path or path[: len(problem.path)] == problem.path for path in faulty
            ):
                found.append(problem)
    return list(dict.fromkeys(found))


def _study(path: Path, draft: Draft) -> Study:
    file = draft.whole()
    return Study(
        name=file.study.name,
        title=file.study.title or file.study.name,
        mode=file.study.mode,
        path=Path(os.path.abspath(path)),  # one spelling, however it was given: keys of steps hold paths relative to it
        participants=draft.participant_ids or (),
        specimens=tuple(Specimen(s.name, s.stiffness_n_per_mm, s.stiffness_se_n_per_mm) for s in file.specimens),
        recordings=entries(draft),
        cocontraction=file.cocontraction,
        fit=file.fit,
        hypotheses=file.hypotheses,
        profile=file.profile,
        schedule=file.schedule,
        simulation=file.simulation,
        scoring=_scoring(file.runs),
        discrimination=file.discrimination,
        calibration=file.calibration,
        runs_source=_runs_source(draft.folder, file.runs),
        results=beside(draft.folder, file.study.results or f".emg2vsa/{file.study.name}"),
        reports=beside(draft.folder, file.study.reports or f"../../reports/{file.study.name}"),
        data=data_folder(draft),
        window=file.window,
    )


def _scoring(table: RunsTable | None) -> RunSettings:
    if table is None:
        return RunSettings()
    return RunSettings(**{each.name: getattr(table, each.name) for each in fields(RunSettings)})


def _runs_source(folder: Path, table: RunsTable | None) -> RunsSource | None:
    if table is None:
        return None
    return RunsSource(
        root=beside(folder, table.root),
        rig=beside(folder, table.rig) if table.rig else None,
        camera=beside(folder, table.camera) if table.camera else None,
    )
