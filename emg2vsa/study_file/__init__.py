"""The study file: TOML in, a checked ``Study`` out, or its problems, each with its line."""

from __future__ import annotations

import csv
import inspect
import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from emg2vsa.settings import PAPER, StageSettings
from emg2vsa.study import Person, RecordingEntry, Study
from emg2vsa.study_file import check_recordings, check_session, check_stages
from emg2vsa.study_file.assembly import study_of
from emg2vsa.study_file.problems import Problem, checked, checked_tables, shown
from emg2vsa.study_file.tables import ParticipantsTable, StudyFile
from emg2vsa.study_file.toml_file import placed, read_toml

__all__ = ["contradictions", "load_study", "missing_files"]


def load_study(path: str | Path, folder: Path | None = None) -> Study:
    """The study in a TOML file.

    Relative paths in the file are resolved against its folder, or against ``folder``, where the study then lies. Data
    files need not exist: see ``missing_files``.

    Raises
    ------
    StudyError
        Lists every problem as ``file:line: key: expected ..., but found ...``: TOML syntax, unknown keys, wrong types,
        values out of range, missing keys, and keys that contradict each other. A table with a problem is not yet
        compared with the others.
    """
    path = Path(path)
    text, raw = read_toml(path, "a study file")
    place = os.path.abspath(path if folder is None else folder / path.name)
    tables, problems = checked_tables(StudyFile, _with_paper(raw))
    of_runs_alone = _is_of_runs_alone(raw)
    if not of_runs_alone:
        wanted = [name for name in ("participants", "recordings") if name not in raw]
        problems += [Problem((name,), f"a table [{name}]", "nothing") for name in wanted]
    people: tuple[Person, ...] = ()
    if participants := tables.get("participants"):
        people, found = _people(participants, os.path.dirname(place))
        problems += found
    sound = {name: table for name, table in tables.items() if name not in {problem.path[0] for problem in problems}}
    if "participants" in sound:
        sound["ids"] = tuple(person.participant for person in people)
    problems += contradictions({**sound, "raw": raw, "of_runs_alone": of_runs_alone})
    if problems:
        raise placed(path, text, dict.fromkeys(problems))
    return study_of(place, StudyFile(**tables), people, raw)


def missing_files(study: Study) -> tuple[RecordingEntry, ...]:
    """The recordings of which a file is not there."""
    return tuple(entry for entry in study.recordings if not all(path.is_file() for path in entry.files))


def _is_of_runs_alone(raw: Mapping[str, Any]) -> bool:
    """Measured runs, and no word of people; an emulated rig needs the schedules that people give."""
    runs, of_people = raw.get("runs"), ("participants", "recordings", "channels", "simulation")
    return isinstance(runs, dict) and "rig" not in runs and not any(name in raw for name in of_people)


def _with_paper(raw: Mapping[str, Any]) -> Mapping[str, Any]:
    """The tables of a file with what ``mode = "paper"`` sets in them, unless they say otherwise."""
    study = raw.get("study")
    if not isinstance(study, dict) or study.get("mode") != "paper":
        return raw
    always = {each.name for each in fields(StageSettings)}
    given = {name: raw.get(name, {}) for name in PAPER if name in raw or name in always}
    return {**raw, **{name: {**PAPER[name], **keys} for name, keys in given.items() if isinstance(keys, dict)}}


def _people(table: ParticipantsTable, folder: str) -> tuple[tuple[Person, ...], list[Problem]]:
    """The participants, given one by one or in the participant_id column of a BIDS participants.tsv."""
    if (table.ids is None) == (table.file is None):
        return (), [Problem(("participants",), "either ids or file", "neither" if table.ids is None else "both")]
    if table.file is None:
        return tuple(map(Person, table.ids or ())), []
    at = ("participants", "file")
    try:
        with open(os.path.join(folder, table.file), encoding="utf-8-sig", newline="") as lines:
            rows = list(csv.DictReader(lines, delimiter="\t", quoting=csv.QUOTE_NONE))
    except (OSError, ValueError, csv.Error) as error:
        found = getattr(error, "strerror", None) or str(error)
        return (), [Problem(at, "a readable table", f"{shown(table.file)}: {found}")]
    ids = [(row.get("participant_id") or "").strip().removeprefix("sub-") for row in rows]
    if not ids or not all(ids):
        return (), [Problem(at, "a tab-separated table with a participant_id in every row", shown(table.file))]
    made, problems = checked(ParticipantsTable, {"ids": ids}, ("participants",))
    problems = [Problem((*at, *p.path[2:]), p.wanted, p.found, p.do) for p in problems]
    about = [{key: _said(row, key) for key in ("age", "sex", "handedness")} for row in rows]
    problems += [
        Problem(at, "an age in years, or n/a", f"{own['age']!r} for {name!r}")
        for name, own in zip(ids, about, strict=True)
        if own["age"] and not _AGE.fullmatch(own["age"])
    ]
    return tuple(Person(name, **own) for name, own in zip(made.ids or (), about, strict=False)), problems


_AGE = re.compile(r"\d{1,3}(\.\d+)?\+?")
"""BIDS writes 89+ for ages that would tell who somebody is."""


def _said(row: Mapping[str, str | None], key: str) -> str:
    """An entry of a BIDS table; "" where it says n/a."""
    text = (row.get(key) or "").strip()
    return "" if text.lower() == "n/a" else text


def contradictions(known: Mapping[str, Any]) -> Iterator[Problem]:
    """What every check finds that may look at tables without fault alone, and at none that was left out.

    A check takes tables as parameters of their names; one that has a default may have been left out.
    """
    for check in (*check_recordings.CHECKS, *check_stages.CHECKS, *check_session.CHECKS):
        wanted = inspect.signature(check).parameters.values()
        if all(each.name in known and (known[each.name] is not None or each.default is None) for each in wanted):
            yield from check(**{each.name: known[each.name] for each in wanted})
