"""A study file as read: every table that could be made out, and the problems of the rest."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields, replace
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

from emg2vsa.settings import (
    PAPER,
    CalibrationSettings,
    ChannelSettings,
    CocontractionSettings,
    DiscriminationSettings,
    FilterSettings,
    FitSettings,
    HypothesisSettings,
    ProfileSettings,
    ScheduleSettings,
    SimulationSettings,
    WindowSettings,
)
from emg2vsa.study_file.problems import Problem, checked, shown, unknown_key
from emg2vsa.study_file.tables import (
    FileTable,
    ParticipantsTable,
    RecordingsTable,
    RunsTable,
    SpecimenTable,
    StudyFile,
    StudyTable,
)

Settings = TypeVar("Settings", FilterSettings, WindowSettings)
_OF_PEOPLE = ("participants", "recordings", "channels", "simulation")


@dataclass
class Draft:
    """Tables by name; None where a table could not be made out (its problem is in ``problems``).

    ``raw`` is the file as TOML gives it: it tells a key that was set from one that has its default.
    """

    raw: Mapping[str, Any]
    folder: Path
    problems: list[Problem] = field(default_factory=list)
    study: StudyTable | None = None
    participants: ParticipantsTable | None = None
    participant_ids: tuple[str, ...] | None = None
    specimens: list[SpecimenTable | None] = field(default_factory=list)
    recordings: RecordingsTable | None = None
    files: list[FileTable | None] = field(default_factory=list)
    channels: ChannelSettings | None = None
    filters: FilterSettings | None = None
    cocontraction: CocontractionSettings | None = None
    window: WindowSettings | None = None
    fit: FitSettings | None = None
    hypotheses: HypothesisSettings | None = None
    profile: ProfileSettings | None = None
    schedule: ScheduleSettings | None = None
    runs: RunsTable | None = None
    discrimination: DiscriminationSettings | None = None
    calibration: CalibrationSettings | None = None
    simulation: SimulationSettings | None = None

    @property
    def is_of_runs_alone(self) -> bool:
        """Measured runs, and no word of people; an emulated rig needs the schedules that people give."""
        runs = self.raw.get("runs")
        return isinstance(runs, dict) and "rig" not in runs and not any(name in self.raw for name in _OF_PEOPLE)

    @property
    def specimen_names(self) -> tuple[str, ...] | None:
        """Names of all specimens; None where one of them is not known."""
        names = tuple(s.name for s in self.specimens if s)
        return names if names and len(names) == len(self.specimens) else None

    def whole(self) -> StudyFile:
        """The study file that a draft without problems is."""
        tables: dict[str, Any] = {f.name: getattr(self, f.name) for f in fields(StudyFile)}
        tables["specimens"] = tuple(self.specimens)
        if self.recordings is not None:
            tables["recordings"] = replace(tables["recordings"], files=tuple(self.files))
        return StudyFile(**tables)

    def muscle_sets(self) -> tuple[tuple[str, ...], ...]:
        """The muscles of the study's channels and of every recording that has its own; () where one is not known."""
        if any("channels" in problem.path for problem in self.problems):
            return ()
        tables = [self.channels.emg] if self.channels else []
        tables += [file.channels.emg for file in self.files if file and file.channels.emg]
        return tuple(dict.fromkeys(tuple(table) for table in tables))

    def own_keys(self, index: int, name: str) -> tuple[str, ...]:
        """Keys that recording ``index`` sets itself in its table ``name``."""
        given = self.raw["recordings"]["files"][index].get(name)
        return tuple(given) if isinstance(given, dict) else ()

    def overlaid(self, table: Settings, index: int, name: str) -> Settings:
        """The study's ``table`` with the keys that recording ``index`` sets itself."""
        own = getattr(self.files[index], name)
        known = {f.name for f in fields(own)}
        return replace(table, **{key: getattr(own, key) for key in self.own_keys(index, name) if key in known})


def read_draft(raw: Mapping[str, Any], folder: Path) -> Draft:
    """Every table of ``raw`` on its own, so that one that is faulty hides no problem of another."""
    draft = Draft(raw, folder)
    kinds = get_type_hints(StudyFile)
    draft.problems += [unknown_key(StudyFile, (key,), ()) for key in raw if key not in kinds]
    required = [f.name for f in fields(StudyFile) if f.default is MISSING and f.default_factory is MISSING]
    required += [] if draft.is_of_runs_alone else ["participants", "recordings"]
    draft.problems += [Problem((key,), f"a table {_heading(key)}", "nothing") for key in required if key not in raw]
    paper = PAPER if _is_paper(raw) else {}
    for name, kind in kinds.items():
        if name in ("specimens", "recordings") or (name not in raw and name in required):
            continue
        _read_table(draft, name, kind, paper.get(name, {}))
    draft.specimens = _read_entries(draft, SpecimenTable, raw.get("specimens", []), ("specimens",))
    _read_recordings(draft)
    _read_participants(draft)
    return draft


def _heading(table: str) -> str:
    return "[[specimens]]" if table == "specimens" else f"[{table}]"


def _is_paper(raw: Mapping[str, Any]) -> bool:
    study = raw.get("study")
    return isinstance(study, dict) and study.get("mode") == "paper"


def _read_table(draft: Draft, name: str, kind: Any, paper: Mapping[str, Any]) -> None:
    given = draft.raw.get(name)
    value = {**paper, **(given or {})} if given is None or isinstance(given, dict) else given
    if given is None and type(None) in getattr(kind, "__args__", ()):
        return
    table, problems = checked(kind, value, (name,))
    setattr(draft, name, table)
    draft.problems += problems


def _read_entries(draft: Draft, kind: Any, values: object, at: tuple[str, ...]) -> list[Any]:
    """The entries of an array of tables, each on its own: None for one that cannot be made out."""
    if not isinstance(values, list):
        draft.problems.append(Problem(at, f"tables under [[{'.'.join(at)}]]", shown(values)))
        return []
    entries = []
    for index, value in enumerate(values):
        entry, problems = checked(kind, value, (*at, index))
        entries.append(entry)
        draft.problems += problems
    if not values and at == ("specimens",) and "specimens" in draft.raw:
        draft.problems.append(Problem(at, "at least one [[specimens]]", "none"))
    return entries


def _read_recordings(draft: Draft) -> None:
    raw = draft.raw.get("recordings")
    if raw is None:
        return
    given = {k: v for k, v in raw.items() if k != "files"} if isinstance(raw, dict) else raw
    draft.recordings, problems = checked(RecordingsTable, given, ("recordings",))
    draft.problems += problems
    if isinstance(raw, dict):
        draft.files = _read_entries(draft, FileTable, raw.get("files", []), ("recordings", "files"))


def _read_participants(draft: Draft) -> None:
    table = draft.participants
    if table is None:
        return
    if (table.ids is None) == (table.file is None):
        if not any(p.path[0] == "participants" for p in draft.problems):
            found = "neither" if table.ids is None else "both"
            draft.problems.append(Problem(("participants",), "either ids or file", found))
    elif table.ids is not None:
        draft.participant_ids = table.ids
    elif table.file is not None:
        draft.participant_ids = _ids_in(draft, table.file)


def _ids_in(draft: Draft, file: str) -> tuple[str, ...] | None:
    """Ids in the participant_id column of a BIDS participants.tsv."""
    at = ("participants", "file")
    try:
        with (draft.folder / file).open(encoding="utf-8-sig", newline="") as lines:
            rows = list(csv.DictReader(lines, delimiter="\t"))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        found = getattr(error, "strerror", None) or str(error)
        draft.problems.append(Problem(at, "a readable table", f"{shown(file)}: {found}"))
        return None
    ids = [(row.get("participant_id") or "").strip().removeprefix("sub-") for row in rows]
    if not ids or not all(ids):
        draft.problems.append(Problem(at, "a tab-separated table with a participant_id in every row", shown(file)))
        return None
    table, problems = checked(ParticipantsTable, {"ids": ids}, ("participants",))
    draft.problems += [Problem((*at, *p.path[2:]), p.wanted, p.found, p.do) for p in problems]
    return table.ids if table else None
