"""Recording files of every known format, read through one front door.

``inspect`` says what a file holds, ``read`` decodes the channels asked for and converts them to volts and newtons, and
``roles.read_roles`` does so for the muscles and the force of a study. The table READERS is tried from top to bottom;
the module of a format is imported when a file of that format is opened, so this package itself imports nothing heavy.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from emg2vsa.errors import RecordingError
from emg2vsa.readers import recognise
from emg2vsa.readers.opened import OpenRecording, StoredChannel, usable
from emg2vsa.readers.si import to_si
from emg2vsa.recordings import ChannelInfo, Recording, no_such_channel


@dataclass(frozen=True)
class Reader:
    """A format: its name, the module whose ``open_recording(path)`` reads it, and how a file of it is recognised."""

    format: str
    module: str
    matches: Callable[[Path, bytes], bool]


READERS: tuple[Reader, ...] = (
    Reader("EDF", "emg2vsa.readers.edf_bdf", recognise.is_edf),
    Reader("BDF", "emg2vsa.readers.edf_bdf", recognise.is_bdf),
    Reader("C3D", "emg2vsa.readers.c3d", recognise.is_c3d),
    Reader("MATLAB", "emg2vsa.readers.matlab", recognise.is_matlab),
    Reader("Trigno Discover CSV", "emg2vsa.readers.discover", recognise.is_discover),
    Reader("EMGworks CSV", "emg2vsa.readers.emgworks", recognise.is_emgworks),
    Reader("text matrix", "emg2vsa.readers.text_matrix", recognise.is_text_matrix),
    Reader("CSV", "emg2vsa.readers.plain_csv", recognise.is_plain_csv),
)


def open_recording(path: Path) -> tuple[str, OpenRecording]:
    """The format of a file and the file opened and validated, its samples not read yet.

    Raises RecordingError where the file is absent, empty, of no known format or damaged.
    """
    path = Path(path)
    try:
        head = _head(path)
    except OSError as error:
        raise RecordingError(
            path, wanted="a readable file", found=error.strerror or "an error", do="Check the path in the study file."
        ) from error
    if not head:
        raise RecordingError(path, wanted="a recording", found="an empty file", do="Export or copy it again.")
    reader = _reader(path, head)
    if reader is None:
        raise RecordingError(
            path, wanted="one of " + ", ".join(reader.format for reader in READERS), found="an unknown format",
            do="Export the recording as CSV with a time column, C3D, EDF/BDF or .mat.",
        )  # fmt: skip
    return reader.format, importlib.import_module(reader.module).open_recording(path)


def reader_module(path: Path) -> str | None:
    """Name of the module that would open the file; None where it is absent, empty or of no known format.

    Reads the first bytes only and imports nothing.
    """
    try:
        head = _head(Path(path))
    except OSError:
        return None
    reader = _reader(Path(path), head) if head else None
    return reader.module if reader else None


def _head(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(recognise.HEAD_BYTES)


def _reader(path: Path, head: bytes) -> Reader | None:
    return next((reader for reader in READERS if reader.matches(path, head)), None)


def inspect(path: Path) -> tuple[str, tuple[ChannelInfo, ...]]:
    """Format and channels of a file. A channel whose rate the file does not let one know has ``fs_hz`` NaN."""
    name, opened = open_recording(path)
    return name, opened.describe()


def read(path: Path, names: Sequence[str]) -> Recording:
    """The channels ``names`` of a file, at their native rates; voltages in V, forces in N, all else as stored.

    Raises RecordingError for an unusable file, an unknown channel, or a NaN or infinite sample in a channel asked for.
    """
    name, opened = open_recording(path)
    stored = load_named(opened, names)
    notes = (*opened.contents.notes, *(note for channel in stored for note in channel.notes))
    return Recording(Path(path), name, tuple(to_si(channel) for channel in stored), tuple(dict.fromkeys(notes)))


def load_named(opened: OpenRecording, names: Sequence[str]) -> list[StoredChannel]:
    """The named channels as stored, each under the name it was asked by; checked to be there, not empty and finite."""
    contents = opened.contents
    index = {**contents.aliases, **{known: i for i, known in enumerate(contents.names)}}
    for name in names:
        if name not in index:
            raise no_such_channel(opened.path, name, contents.names)
    return [
        usable(opened.path, name, channel)
        for name, channel in zip(names, opened.load([index[name] for name in names]), strict=True)
    ]
