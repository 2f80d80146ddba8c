"""Checks of where the recordings are, and of which channel plays which role."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

from emg2vsa.settings import EmgChannelSettings, ForceChannelSettings
from emg2vsa.study_file.draft import Draft
from emg2vsa.study_file.lines import KeyPath
from emg2vsa.study_file.problems import Problem, nearest, shown
from emg2vsa.study_file.tables import FileTable, RecordingsTable

_KEYS_OF_LAYOUT = {
    "bids": ("root", "task", "extension"),
    "pattern": ("pattern", "force_pattern"),
    "files": (),
}
_REQUIRED = {"bids": ("root", "task"), "pattern": ("pattern",), "files": ("files",)}
_PLACEHOLDERS = ("participant", "specimen")


def recording_problems(draft: Draft) -> Iterator[Problem]:
    """Layout, placeholders, labels, the listed files and the channels."""
    if draft.recordings:
        yield from _layout(draft, draft.recordings)
        yield from _patterns(draft, draft.recordings)
        if draft.recordings.layout == "bids":
            yield from _labels(draft, draft.recordings)
        yield from _files(draft, draft.recordings)
    if not draft.is_of_runs_alone:
        yield from _channels(draft)


def _layout(draft: Draft, table: RecordingsTable) -> Iterator[Problem]:
    given = draft.raw["recordings"]
    for key in _REQUIRED[table.layout]:
        if key not in given:
            yield Problem(("recordings", key), f"a key {key!r} with layout = {table.layout!r}", "nothing")
    for layout, keys in _KEYS_OF_LAYOUT.items():
        for key in keys:
            if key in given and layout != table.layout:
                found = f"{key!r} with layout = {table.layout!r}"
                yield Problem(("recordings", key), f"keys of this layout only ({key!r} is of {layout!r})", found)


def _patterns(draft: Draft, table: RecordingsTable) -> Iterator[Problem]:
    counts = {"participant": len(draft.participant_ids or ()), "specimen": len(draft.specimen_names or ())}
    for key in ("pattern", "force_pattern"):
        pattern = getattr(table, key)
        if pattern is None:
            continue
        path = ("recordings", key)
        names = re.findall(r"\{([^{}]*)\}", pattern)
        unknown = [name for name in names if name not in _PLACEHOLDERS]
        for name in unknown:
            do = nearest(name, _PLACEHOLDERS)
            yield Problem(path, "{participant} and {specimen} as placeholders", f"{{{name}}}", do)
        for name in _PLACEHOLDERS:
            if not unknown and name not in names and counts[name] > 1:
                yield Problem(path, f"{{{name}}} in it, as there are {counts[name]} {name}s", shown(pattern))


def _labels(draft: Draft, table: RecordingsTable) -> Iterator[Problem]:
    labels: list[tuple[KeyPath, str | None]] = [(("recordings", "task"), table.task)]
    labels += [(("participants",), name) for name in draft.participant_ids or ()]
    labels += [(("specimens", i, "name"), s.name) for i, s in enumerate(draft.specimens) if s]
    for path, label in labels:
        if label is not None and not (label.isascii() and label.isalnum()):
            yield Problem(path, "letters and digits only, as it is a label in BIDS file names", repr(label))


def _files(draft: Draft, table: RecordingsTable) -> Iterator[Problem]:
    seen: set[tuple[str, str]] = set()
    for index, file in enumerate(draft.files):
        if file is None:
            continue
        cell = (file.participant, file.specimen)
        at: KeyPath = ("recordings", "files", index)
        if cell in seen:
            yield Problem(at, "one recording of a participant on a specimen", f"{'/'.join(cell)} again")
        seen.add(cell)
        if table.layout == "files" and file.emg is None:
            yield Problem((*at, "emg"), "a key 'emg' with layout = 'files'", "nothing")
        if "force_n" in draft.own_keys(index, "window"):
            do = "Set it in [window]: fits and profiles share its bins."
            yield Problem((*at, "window", "force_n"), "one force window for all recordings", "another one", do)


def _channels(draft: Draft) -> Iterator[Problem]:
    if draft.channels:
        yield from _one_role_each(draft.channels.emg, draft.channels.force, ("channels",))
    for index, file in enumerate(draft.files):
        if file:
            yield from _file_channels(draft, file, ("recordings", "files", index, "channels"))
    if "channels" not in draft.raw and _needs_study_channels(draft):
        do = "Or give every recording its own under [[recordings.files]]."
        yield Problem(
            ("channels",), "a table [channels.emg.<muscle>] for each muscle and [channels.force]", "nothing", do
        )


def _file_channels(draft: Draft, file: FileTable, at: KeyPath) -> Iterator[Problem]:
    given = file.channels
    emg = given.emg or (draft.channels.emg if draft.channels else {})
    force = given.force or (draft.channels.force if draft.channels else None)
    same_file = file.force is None
    if (given.emg or given.force) and same_file:
        yield from _one_role_each(emg, force, at)


def _one_role_each(
    emg: Mapping[str, EmgChannelSettings], force: ForceChannelSettings | None, at: KeyPath
) -> Iterator[Problem]:
    """No channel plays two roles. Force in a file of its own may well bear the name of an EMG channel."""
    roles: dict[str, str] = {}
    for role, channel in emg.items():
        if roles.setdefault(channel.name, role) != role:
            path = (*at, "emg", role, "name")
            yield Problem(
                path, "a channel of its own for each muscle", f"{channel.name!r}, as for {roles[channel.name]}"
            )
    if force and force.name in roles:
        yield Problem((*at, "force", "name"), "a channel of its own", f"{force.name!r}, as for {roles[force.name]}")


def _needs_study_channels(draft: Draft) -> bool:
    all_named = all(file and file.channels.emg and file.channels.force for file in draft.files)
    return not (draft.recordings and draft.recordings.layout == "files" and draft.files and all_named)
