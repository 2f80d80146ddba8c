"""The study file: TOML in, a checked ``Study`` out, or every problem at once with its line."""

from __future__ import annotations

import os
import re
import tomllib
from pathlib import Path
from typing import Any

from emg2vsa.errors import StudyError
from emg2vsa.study import RecordingEntry, Specimen, Study
from emg2vsa.study_file.check_names import name_problems
from emg2vsa.study_file.check_recordings import recording_problems
from emg2vsa.study_file.check_stages import stage_problems
from emg2vsa.study_file.draft import Draft, read_draft
from emg2vsa.study_file.entries import beside, data_folder, entries
from emg2vsa.study_file.lines import key_lines, line_of
from emg2vsa.study_file.problems import Problem
from emg2vsa.study_file.schema import json_schema

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
    text, raw = _toml(path)
    draft = read_draft(raw, Path(os.path.abspath(path)).parent)
    problems = _all_problems(draft)
    if problems:
        lines = key_lines(text)
        placed = sorted(((line_of(p.path, lines), str(p)) for p in problems), key=lambda item: item[0])
        raise StudyError(tuple(f"{path}:{line}: {problem}" for line, problem in placed))
    return _study(path, draft)


def missing_files(study: Study) -> tuple[RecordingEntry, ...]:
    """The recordings whose EMG or force file is not there."""
    return tuple(
        r for r in study.recordings if not r.emg_file.is_file() or (r.force_file and not r.force_file.is_file())
    )


def _toml(path: Path) -> tuple[str, dict[str, Any]]:
    try:
        # line ends as TOML counts them, whatever the editor wrote
        text = path.read_bytes().decode("utf-8").replace("\r\n", "\n")
    except OSError as error:
        raise StudyError((f"{path}: wanted a study file; found none to read ({error.strerror}).",)) from None
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise StudyError(
            (f"{path}:{line}: wanted UTF-8 text; found byte 0x{error.object[error.start]:02x}.",)
        ) from None
    try:
        return text, tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        what, _, at = str(error).rpartition(" (at ")
        digits = re.findall(r"\d+", at) or [str(text.count("\n") + 1)]
        raise StudyError((f"{path}:{':'.join(digits)}: wanted valid TOML; found: {what}.",)) from None


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
        specimens=tuple(Specimen(s.name, s.stiffness_n_per_mm) for s in file.specimens),
        recordings=entries(draft),
        cocontraction=file.cocontraction,
        fit=file.fit,
        hypotheses=file.hypotheses,
        profile=file.profile,
        schedule=file.schedule,
        simulation=file.simulation,
        results=beside(draft.folder, file.study.results or f".emg2vsa/{file.study.name}"),
        reports=beside(draft.folder, file.study.reports or f"../../reports/{file.study.name}"),
        data=data_folder(draft),
        window=file.window,
    )
