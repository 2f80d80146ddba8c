"""From the layout to the list of recordings, each with its files and settings."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from emg2vsa.settings import ChannelSettings
from emg2vsa.study import RecordingEntry
from emg2vsa.study_file.draft import Draft
from emg2vsa.study_file.tables import FileChannels, FileTable, RecordingsTable, StudyFile


def beside(folder: Path, path: str) -> Path:
    """``path`` relative to ``folder``, without the dots; nothing of it need exist."""
    return Path(os.path.normpath(folder / path))


def entries(draft: Draft) -> tuple[RecordingEntry, ...]:
    """All recordings of a draft without problems: the layout's by participant and specimen, or the listed ones."""
    file = draft.whole()
    table = file.recordings
    if table is None:
        return ()
    listed = {(f.participant, f.specimen): index for index, f in enumerate(table.files)}
    cells = [(p, s.name) for p in draft.participant_ids or () for s in file.specimens]
    if table.layout == "files":
        cells = list(listed)
    return tuple(_entry(draft, file, table, cell, listed.get(cell)) for cell in cells)


def data_folder(draft: Draft) -> Path:
    """The folder that holds the recordings of a layout; for listed files the one around them all.

    A study without recordings has the folder of its file.
    """
    table = draft.whole().recordings
    if table is None:
        return draft.folder
    match table.layout:
        case "bids":
            return beside(draft.folder, table.root or "")
        case "pattern":
            fixed = (table.pattern or "").partition("{")[0]
            return beside(draft.folder, fixed.rpartition("/")[0])
        case _:
            return Path(os.path.commonpath([entry.emg_file.parent for entry in entries(draft)]))


def _entry(
    draft: Draft, file: StudyFile, table: RecordingsTable, cell: tuple[str, str], index: int | None
) -> RecordingEntry:
    own, filters, window = None, file.filters, file.window
    if index is not None:
        own = table.files[index]
        filters, window = draft.overlaid(filters, index, "filters"), draft.overlaid(window, index, "window")
    emg, force = _paths(table, cell, own)
    return RecordingEntry(
        participant=cell[0],
        specimen=cell[1],
        emg_file=beside(draft.folder, emg),
        force_file=beside(draft.folder, force) if force else None,
        channels=_channels(file.channels, own.channels if own else FileChannels()),
        filters=filters,
        window=window,
    )


def _paths(table: RecordingsTable, cell: tuple[str, str], own: FileTable | None) -> tuple[str, str | None]:
    """EMG file and force file as the study file writes them; one that a recording names itself goes first."""
    participant, specimen = cell
    emg, force = (_filled(pattern or "", participant, specimen) for pattern in (table.pattern, table.force_pattern))
    if table.layout == "bids":
        name = f"sub-{participant}_task-{table.task}_acq-{specimen}_emg.{table.extension}"
        emg = f"{table.root}/sub-{participant}/emg/{name}"
    return (own.emg or emg, own.force or force or None) if own else (emg, force or None)


def _filled(pattern: str, participant: str, specimen: str) -> str:
    return pattern.replace("{participant}", participant).replace("{specimen}", specimen)


def _channels(study: ChannelSettings | None, own: FileChannels) -> ChannelSettings:
    """The study's channels with what a recording replaces; either may be all there is."""
    given: dict[str, Any] = {"emg": own.emg or (study and study.emg), "force": own.force or (study and study.force)}
    return ChannelSettings(**{role: channel for role, channel in given.items() if channel})
