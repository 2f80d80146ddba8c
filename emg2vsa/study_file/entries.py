"""From the layout to the list of recordings, each with its files and settings."""

from __future__ import annotations

import os
from pathlib import Path

from emg2vsa.settings import ChannelSettings, FilterSettings, WindowSettings
from emg2vsa.study import RecordingEntry
from emg2vsa.study_file.draft import Draft
from emg2vsa.study_file.tables import FileChannels, FileTable, RecordingsTable


def beside(folder: Path, path: str) -> Path:
    """``path`` relative to ``folder``, without the dots; nothing of it need exist."""
    return Path(os.path.normpath(folder / path))


def entries(draft: Draft) -> tuple[RecordingEntry, ...]:
    """All recordings of a draft without problems: the layout's by participant and specimen, or the listed ones."""
    assert draft.recordings and draft.participant_ids and draft.specimen_names
    listed = {(f.participant, f.specimen): i for i, f in enumerate(draft.files) if f}
    cells = [(p, s) for p in draft.participant_ids for s in draft.specimen_names]
    if draft.recordings.layout == "files":
        cells = list(listed)
    return tuple(_entry(draft, draft.recordings, cell, listed.get(cell)) for cell in cells)


def _entry(draft: Draft, table: RecordingsTable, cell: tuple[str, str], index: int | None) -> RecordingEntry:
    assert draft.filters and draft.window
    file = draft.files[index] if index is not None else None
    emg, force = _paths(table, cell, file)
    filters: FilterSettings = draft.filters
    window: WindowSettings = draft.window
    if index is not None:
        filters, window = draft.overlaid(filters, index, "filters"), draft.overlaid(window, index, "window")
    return RecordingEntry(
        participant=cell[0],
        specimen=cell[1],
        emg_file=beside(draft.folder, emg),
        force_file=beside(draft.folder, force) if force else None,
        channels=_channels(draft.channels, file.channels if file else FileChannels()),
        filters=filters,
        window=window,
    )


def _paths(table: RecordingsTable, cell: tuple[str, str], file: FileTable | None) -> tuple[str, str | None]:
    participant, specimen = cell
    emg = table.pattern or ""
    if table.layout == "bids":
        name = f"sub-{participant}_task-{table.task}_acq-{specimen}_emg.{table.extension}"
        emg = f"{table.root}/sub-{participant}/emg/{name}"
    else:
        emg = emg.format(participant=participant, specimen=specimen)
    force = table.force_pattern.format(participant=participant, specimen=specimen) if table.force_pattern else None
    if file is None:
        return emg, force
    return file.emg or emg, file.force or force


def _channels(study: ChannelSettings | None, own: FileChannels) -> ChannelSettings:
    if study is None:
        assert own.emg and own.force
        return ChannelSettings(emg=own.emg, force=own.force)
    return ChannelSettings(emg=own.emg or study.emg, force=own.force or study.force)
