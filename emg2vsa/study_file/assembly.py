"""From a study file without problems to the study: paths resolved, and every recording with its files and settings."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from emg2vsa.settings import ChannelSettings, RunSettings, StageSettings
from emg2vsa.study import RecordingEntry, RunsSource, Specimen, Study
from emg2vsa.study_file.tables import (
    FileChannels,
    FileTable,
    RecordingsTable,
    RunsTable,
    StudyFile,
    overlaid,
)
from emg2vsa.study_file.toml_file import beside, reports_beside


def study_of(path: str, file: StudyFile, ids: tuple[str, ...], raw: Mapping[str, Any]) -> Study:
    """The study of a file without problems. ``ids``: the participants. ``raw``: tells which keys a recording sets."""
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
            Specimen(s.name, s.stiffness_n_per_mm, s.stiffness_se_n_per_mm, s.plate_adjusted_r2) for s in file.specimens
        ),
        recordings=recordings,
        results=beside(folder, about.results or f".emg2vsa/{about.name}"),
        reports=beside(folder, about.reports) if about.reports else reports_beside(folder, about.name),
        data=_data_folder(folder, file.recordings, recordings),
        scoring=RunSettings(**{each.name: getattr(file.runs, each.name) for each in fields(RunSettings)})
        if file.runs
        else RunSettings(),
        runs_source=_runs_source(folder, file.runs) if file.runs else None,
    )


def _runs_source(folder: Path, table: RunsTable) -> RunsSource:
    return RunsSource(
        root=beside(folder, table.root or ("runs-virtual" if table.rig else "runs")),
        rig=beside(folder, table.rig) if table.rig else None,
        camera=beside(folder, table.camera) if table.camera else None,
    )


def _data_folder(folder: Path, table: RecordingsTable | None, recordings: tuple[RecordingEntry, ...]) -> Path:
    """The folder that holds the recordings of a layout; for listed files the one around them all.

    A study without recordings has the folder of its file.
    """
    if table is None:
        return folder
    if table.layout == "files":
        return Path(os.path.commonpath([os.path.dirname(entry.emg_file) for entry in recordings]))
    fixed = (table.pattern or "").partition("{")[0].rpartition("/")[0]
    return beside(folder, (table.root if table.layout == "bids" else fixed) or "")


def _entries(
    folder: Path, file: StudyFile, table: RecordingsTable, ids: Sequence[str], given: Sequence[Mapping[str, Any]]
) -> tuple[RecordingEntry, ...]:
    """All recordings: the layout's by participant and specimen, or the listed ones.

    Recordings without settings of their own share the study's, as the same objects.
    """
    listed = {(own.participant, own.specimen): (own, keys) for own, keys in zip(table.files, given, strict=True)}
    cells = list(listed) if table.layout == "files" else [(p, s.name) for p in ids for s in file.specimens]
    entries = []
    for cell in cells:
        own, keys = listed.get(cell, (None, {}))
        emg, force = _files(table, cell, own)
        entries.append(
            RecordingEntry(
                participant=cell[0],
                specimen=cell[1],
                emg_file=beside(folder, emg),
                force_file=beside(folder, force) if force else None,
                channels=_channels(file.channels, own.channels if own else None),
                filters=overlaid(file.filters, own.filters, keys["filters"]) if own and own.filters else file.filters,
                window=overlaid(file.window, own.window, keys["window"]) if own and own.window else file.window,
            )
        )
    return tuple(entries)


def _files(table: RecordingsTable, cell: tuple[str, str], own: FileTable | None) -> tuple[str, str | None]:
    """EMG file and force file as the study file writes them; one that a recording names itself goes first."""
    participant, specimen = cell
    emg, force = (own.emg, own.force) if own else (None, None)
    if table.layout == "bids":
        name = f"sub-{participant}_task-{table.task}_acq-{specimen}_emg.{table.extension}"
        return emg or f"{table.root}/sub-{participant}/emg/{name}", force
    return emg or _filled(table.pattern or "", cell), force or _filled(table.force_pattern or "", cell) or None


def _filled(pattern: str, cell: tuple[str, str]) -> str:
    return pattern.replace("{participant}", cell[0]).replace("{specimen}", cell[1])


def _channels(study: ChannelSettings | None, own: FileChannels | None) -> ChannelSettings:
    """The study's channels with what a recording replaces; either may be all there is."""
    roles: dict[str, Any] = {"emg": own.emg, "force": own.force} if own else {}
    given = {role: channel for role, channel in roles.items() if channel}
    if study is None:
        return ChannelSettings(**given)
    return replace(study, **given) if given else study
