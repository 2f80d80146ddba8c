"""From a study file without problems to the study: paths resolved, and every recording with its files and settings."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from emg2vsa.errors import SettingError
from emg2vsa.settings import ChannelSettings, PressJudgement, RunSettings, StageSettings
from emg2vsa.study import (
    Person,
    RecordingEntry,
    RecordingPart,
    RunsSource,
    Specimen,
    Study,
    plates_beside,
    registration_of,
)
from emg2vsa.study_file.patterns import REPETITION, Cell, Found, files_by_cell, filled
from emg2vsa.study_file.tables import (
    FileChannels,
    FileTable,
    RecordingsTable,
    RunsTable,
    StudyFile,
    overlaid,
)
from emg2vsa.study_file.toml_file import beside, reports_beside, spelled_beside


def study_of(path: str, file: StudyFile, people: tuple[Person, ...], raw: Mapping[str, Any]) -> Study:
    """The study of a file without problems. ``people`` took part. ``raw``: tells which keys a recording sets."""
    ids = tuple(person.participant for person in people)
    folder, about = Path(os.path.dirname(path)), file.study
    given = raw["recordings"].get("files", []) if file.recordings else []
    recordings = _entries(folder, file, file.recordings, ids, given) if file.recordings else ()
    return Study(
        **{each.name: getattr(file, each.name) for each in fields(StageSettings)},
        name=about.name,
        title=about.title or about.name,
        mode=about.mode,
        path=Path(path),  # one spelling, however it was given: keys of steps hold paths relative to it
        participants=ids,
        specimens=tuple(
            Specimen(
                s.name, s.stiffness_n_per_mm, s.stiffness_se_n_per_mm, s.plate_adjusted_r2, s.stiffness_range_n,
                s.stiffness_change, s.diameter_mm, s.height_mm, s.ends,
            )
            for s in file.specimens
        ),
        recordings=recordings,
        results=beside(folder, about.results or f".emg2vsa/{about.name}"),
        reports=beside(folder, about.reports) if about.reports else reports_beside(folder, about.name),
        data=_data_folder(folder, file.recordings, recordings),
        judgements=tuple(
            PressJudgement(own.participant, own.specimen, own.repetition, own.reason, excludes)
            for excludes, listed in ((True, file.exclude), (False, file.accept))
            for own in listed
        ),
        people=people if any(person.age or person.sex or person.handedness for person in people) else (),
        scoring=RunSettings(**{each.name: getattr(file.runs, each.name) for each in fields(RunSettings)})
        if file.runs
        else RunSettings(),
        runs_source=_runs_source(folder, file.runs) if file.runs else None,
        session=file.session,
        registration=_registration(Path(path), about.registration),
        task=(file.recordings.task if file.recordings else None) or "",
        visits=file.recordings.visits if file.recordings else (),
    )  # fmt: skip


def _registration(path: Path, named: str | None) -> Path | None:
    default = registration_of(path)
    return beside(path.parent, named) if named else default if os.path.lexists(default) else None


def _runs_source(folder: Path, table: RunsTable) -> RunsSource:
    root = beside(folder, table.root or ("runs-virtual" if table.rig else "runs"))
    return RunsSource(
        root=root,
        plates=plates_beside(root),
        rig=beside(folder, table.rig) if table.rig else None,
        camera=beside(folder, table.camera) if table.camera else None,
        domes=beside(folder, table.domes) if table.domes else None,
    )


def _data_folder(folder: Path, table: RecordingsTable | None, recordings: tuple[RecordingEntry, ...]) -> Path:
    """The folder that holds the recordings of a layout; for listed files the one around them all.

    A study without recordings has the folder of its file.
    """
    if table is None:
        return folder
    if table.layout == "files":
        return Path(os.path.commonpath([os.path.dirname(path) for entry in recordings for path in entry.files[:1]]))
    fixed = re.split(r"[{*]", table.pattern or "", maxsplit=1)[0].rpartition("/")[0]
    return beside(folder, (table.root if table.layout == "bids" else fixed) or "")


def _entries(
    folder: Path, file: StudyFile, table: RecordingsTable, ids: Sequence[str], given: Sequence[Mapping[str, Any]]
) -> tuple[RecordingEntry, ...]:
    """What every participant pressed: the layout's cells by participant and specimen, or the listed ones.

    Recordings without settings of their own share the study's, as the same objects.
    """
    listed: dict[Cell, list[tuple[FileTable, Mapping[str, Any]]]] = {}
    for file_table, set_keys in zip(table.files, given, strict=True):
        listed.setdefault((file_table.participant, file_table.specimen), []).append((file_table, set_keys))
    cells = list(listed) if table.layout == "files" else [(p, s.name) for p in ids for s in file.specimens]
    mvc = {one: tuple(beside(folder, m.emg) for m in file.mvc if m.participant == one) for one in ids}
    found = _found(folder, table, cells)
    entries = []
    for cell in cells:
        first, *further = _parts(folder, file.channels, found.get(cell, ()), [each for each, _ in listed.get(cell, ())])
        own: FileTable | None
        own, keys = listed[cell][0] if cell in listed else (None, {})
        entries.append(
            RecordingEntry(
                participant=cell[0],
                specimen=cell[1],
                emg_file=first.emg_file,
                force_file=first.force_file,
                channels=first.channels,
                filters=overlaid(file.filters, own.filters, keys["filters"]) if own and own.filters else file.filters,
                window=overlaid(file.window, own.window, keys["window"]) if own and own.window else file.window,
                mvc_files=mvc.get(cell[0], ()),
                fault=first.fault,
                further=tuple(further),
                visit=first.visit,
            )
        )
    return tuple(entries)


Files = tuple[Found, Found | None, str]
"""EMG file and force file of a recording, as the study file writes them, and label of the visit."""


def _found(folder: Path, table: RecordingsTable, cells: Sequence[Cell]) -> dict[Cell, list[Files]]:
    """The files of every cell where the layout says."""
    if table.layout == "files":
        return {}
    if table.layout == "bids":
        return _at_visits(folder, table, cells)
    emg = files_by_cell(folder, table.pattern or "", cells)
    if not table.force_pattern:
        return {cell: [(one, None, "") for one in emg[cell].values()] for cell in cells}
    force = files_by_cell(folder, table.force_pattern, cells)
    absent = {cell: Found(filled(table.force_pattern, cell)) for cell in cells}
    return {cell: [(one, force[cell].get(n, absent[cell]), "") for n, one in emg[cell].items()] for cell in cells}


def _at_visits(folder: Path, table: RecordingsTable, cells: Sequence[Cell]) -> dict[Cell, list[Files]]:
    """The files of every cell at the visits at which anything of its participant was recorded; at the first without."""
    found: dict[Cell, list[Files]] = {cell: [] for cell in cells}
    for who in dict.fromkeys(cell[0] for cell in cells):
        own_folder = spelled_beside(folder, f"{table.root}/sub-{who}")
        names = sorted(os.listdir(own_folder)) if os.path.isdir(own_folder) else []
        for name in (each for each in names if each.startswith("ses-") and each[4:] not in table.visits):
            path = Path(own_folder, name)
            if any(path.glob(f"emg/*_task-{table.task}_acq-*_emg.{table.extension}")):
                raise SettingError(
                    path, wanted=f"a visit of [recordings] visits ({', '.join(table.visits) or 'none'})",
                    found=f"{path.name} of {who}, which is recorded but not in [recordings] visits",
                    do="Add it there, or move the folder away.",
                )  # fmt: skip
    at = {visit: _bids(folder, table, cells, visit) for visit in table.visits or ("",)}
    first = next(iter(at))
    for visit, own in at.items() if len(at) > 1 else ():
        there = {cell[0] for cell in cells for one in own[cell].values() if _is_there(folder, one)}
        for cell in cells:
            if cell[0] in there:
                found[cell] += [(one, None, visit) for one in own[cell].values()]
    return {cell: files or [(one, None, first) for one in at[first][cell].values()] for cell, files in found.items()}


def _bids(folder: Path, table: RecordingsTable, cells: Sequence[Cell], visit: str) -> dict[Cell, dict[int, Found]]:
    """The one recording of a cell at a visit, or where that is absent its numbered runs."""
    above, ses = (f"/ses-{visit}", f"_ses-{visit}") if visit else ("", "")
    stem = f"{table.root}/sub-{{participant}}{above}/emg/sub-{{participant}}{ses}_task-{table.task}_acq-{{specimen}}"
    single = files_by_cell(folder, f"{stem}_emg.{table.extension}", cells)
    absent = [cell for cell in cells if not _is_there(folder, single[cell][0])]
    runs = files_by_cell(folder, f"{stem}_run-{REPETITION}_emg.{table.extension}", absent)
    return single | {cell: numbered for cell, numbered in runs.items() if 0 not in numbered}


def _is_there(folder: Path, found: Found) -> bool:
    return os.path.exists(spelled_beside(folder, found.file))


def _parts(
    folder: Path, channels: ChannelSettings | None, found: Sequence[Files], own: Sequence[FileTable]
) -> list[RecordingPart]:
    """The recordings of one cell: those listed with a file, else those found, with the channels of a listed one."""
    listed = [table for table in own if table.emg]
    pairs: list[tuple[Found, Found | None, FileTable | None, str]]
    if listed:
        forces = [force for _, force, _ in found] if len(found) == len(listed) == 1 else [None] * len(listed)
        pairs = [(Found(str(table.emg)), force, table, "") for table, force in zip(listed, forces, strict=True)]
    else:
        pairs = [(emg, force, own[0] if own else None, visit) for emg, force, visit in found]
    parts = []
    for emg, force, table, visit in pairs:
        if table and table.force:
            force = Found(table.force)
        parts.append(
            RecordingPart(
                emg_file=beside(folder, emg.file),
                force_file=beside(folder, force.file) if force else None,
                channels=_channels(channels, table.channels if table else None),
                fault=emg.fault or (force.fault if force else ""),
                visit=visit,
            )
        )
    return parts


def _channels(study: ChannelSettings | None, own: FileChannels | None) -> ChannelSettings:
    """The study's channels with what a recording replaces; either may be all there is."""
    roles: dict[str, Any] = {"emg": own.emg, "force": own.force} if own else {}
    given = {role: channel for role, channel in roles.items() if channel}
    if study is None:
        return ChannelSettings(**given)
    return replace(study, **given) if given else study
