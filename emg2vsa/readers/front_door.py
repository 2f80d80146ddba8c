"""The front door: a file of any known format, opened, described and read.

``inspect`` says what a file holds; ``read`` decodes the channels asked for and converts them to volts and newtons. The
module of a format is imported when a file of that format is opened.
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from pathlib import Path

from emg2vsa.errors import RecordingError
from emg2vsa.readers.formats import READERS, head_of, reader_of
from emg2vsa.readers.opened import OpenRecording, StoredChannel, usable
from emg2vsa.readers.si import to_si
from emg2vsa.recordings import ChannelInfo, Recording, no_such_channel


def open_recording(path: Path) -> tuple[str, OpenRecording]:
    """The format of a file and the file opened and validated, its samples not read yet.

    Raises RecordingError where the file is absent, empty, of no known format or damaged.
    """
    path = Path(path)
    try:
        head = head_of(path)
    except OSError as error:
        raise RecordingError(
            path, wanted="a readable file", found=error.strerror or "an error", do="Check the path in the study file."
        ) from error
    if not head:
        raise RecordingError(path, wanted="a recording", found="an empty file", do="Export or copy it again.")
    reader = reader_of(path, head)
    if reader is None:
        raise RecordingError(
            path, wanted="one of " + ", ".join(reader.format for reader in READERS), found="an unknown format",
            do="Export the recording as CSV with a time column, C3D, EDF/BDF or .mat.",
        )  # fmt: skip
    return reader.format, importlib.import_module(reader.module).open_recording(path)


def inspect(path: Path) -> tuple[str, tuple[ChannelInfo, ...]]:
    """Format and channels of a file. A channel whose rate the file does not let one know has ``fs_hz`` NaN."""
    name, opened = open_recording(path)
    return name, opened.describe()


def read(path: Path, names: Sequence[str]) -> Recording:
    """The channels ``names`` of a file, at their native rates; voltages in V, forces in N, all else as stored.

    Missing samples stay NaN, with a note. Raises RecordingError for an unusable file, an unknown channel, or a channel
    asked for that is infinite anywhere or misses half of its samples.
    """
    name, opened = open_recording(path)
    stored = load_named(opened, names)
    notes = (*opened.contents.notes, *(note for channel in stored for note in channel.notes))
    return Recording(Path(path), name, tuple(to_si(channel) for channel in stored), tuple(dict.fromkeys(notes)))


def load_named(opened: OpenRecording, names: Sequence[str]) -> list[StoredChannel]:
    """The named channels as stored, each under the name it was asked by; checked as in ``usable``."""
    contents = opened.contents
    index = {**contents.aliases, **{known: i for i, known in enumerate(contents.names)}}
    for name in names:
        if name not in index:
            raise no_such_channel(opened.path, name, contents.names)
    return [
        usable(opened.path, name, channel)
        for name, channel in zip(names, opened.load([index[name] for name in names]), strict=True)
    ]
