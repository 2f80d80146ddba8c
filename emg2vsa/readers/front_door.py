"""The front door: a file of any known format, opened, described and read.

``inspect`` says what a file holds; ``read`` decodes the channels asked for and converts them to volts and newtons. The
module of a format is imported when a file of that format is opened: in a child process, where it calls a foreign
decoder.
"""

from __future__ import annotations

import stat
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from casr.by_name import module_named
from casr.counts import count
from casr.decoder_process import DecoderFailed, DecoderLost, InChild, Limits
from casr.errors import install_extra, said_by
from emg2vsa.errors import Emg2vsaError, PassingError, RecordingError, UnsupportedError
from emg2vsa.readers.formats import READERS, Reader, head_of, reader_of, refused
from emg2vsa.readers.opened import Contents, OpenRecording, StoredChannel, to_si, usable
from emg2vsa.readers.plugin_readers import Noted, plugin_reader
from emg2vsa.recordings import ChannelInfo, Recording, no_such_channel
from emg2vsa.settings import ReadingSettings

_READING = ReadingSettings()


def open_recording(path: Path, reading: ReadingSettings = _READING) -> tuple[str, OpenRecording]:
    """The format of a file and the file opened and validated, its samples not read yet.

    reading : limits of a foreign decoder, for this and for every later request to the opened file.
    RecordingError : no readable file, empty, of no known format, or broken.
    """
    path = Path(path)
    try:
        kind = path.stat().st_mode
        head = head_of(path) if stat.S_ISREG(kind) or stat.S_ISDIR(kind) else None
    except OSError as error:
        found = error.strerror or "an error"
        if isinstance(error, FileNotFoundError) and any(text in str(path) for text in ("*", "{repetition}")):
            found = "no file that matches this pattern"  # as the study file has it, for want of a match
        raise RecordingError(path, wanted="a readable file", found=found, do="Check the path.") from error
    if head is None:  # reading it may never end
        raise RecordingError(
            path, wanted="a file", found="a pipe or a device", do="Save its data in a file, and name this file."
        )
    if not head:
        raise RecordingError(path, wanted="a recording", found="an empty file", do="Export or copy it again.")
    if (not_read := refused(path, head)) is not None:
        raise RecordingError(path, wanted="a recording in a format that is read", found=not_read[0], do=not_read[1])
    reader = reader_of(path, head)
    faults: tuple[str, ...] = ()
    if reader is None or reader.any_text:
        plugin, faults = plugin_reader(path, head)
        if plugin is not None:
            _count(path)
            return plugin.format, plugin.open(path)
    if reader is None:
        raise RecordingError(
            path, wanted=f"one of the {len(READERS)} formats of docs/reference/formats.md",
            found="; ".join(["an unknown format", *faults]),
            do="Export the recording as CSV with a time column, C3D, EDF/BDF or .mat.",
        )  # fmt: skip
    try:
        opened = _opened(path, reader, reading)
        return reader.format, Noted(opened, faults) if faults else opened
    except RecordingError as error:
        given_up = isinstance(error, UnsupportedError) or isinstance(error.__cause__, DecoderFailed)
        if reader.second is not None and given_up:
            with suppress(RecordingError):  # what the first reader says of the file counts
                return reader.format, _opened(path, reader.second, reading)
        raise


def _count(path: Path) -> None:
    count("files read")
    count("bytes read", path.stat().st_size)


def _opened(path: Path, reader: Reader, reading: ReadingSettings) -> OpenRecording:
    _count(path)
    if reader.library is not None:
        return _OpenInChild(path, reader, reading)
    opened: OpenRecording = module_named(reader.module).open_recording(path)
    return opened


class _OpenInChild:
    """A file that a foreign decoder holds open in the child process."""

    def __init__(self, path: Path, reader: Reader, reading: ReadingSettings) -> None:
        self.path, self._reader = path, reader
        limits = Limits(reading.max_seconds, reading.max_memory_mb).for_file(path)
        with self._failures():
            self._file = InChild(str(reader.library), reader.module, "open_recording", (path,), limits, "contents")
            self.contents: Contents = self._file.told

    def describe(self) -> tuple[ChannelInfo, ...]:
        with self._failures():
            return tuple(self._file.ask("describe"))

    def load(self, indices: Sequence[int]) -> list[StoredChannel]:
        with self._failures():
            return list(self._file.ask("load", list(indices)))

    @contextmanager
    def _failures(self) -> Iterator[None]:
        wanted = f"{self._reader.format} data that {self._reader.library} can read"
        try:
            yield
        except DecoderLost as error:
            raise PassingError(
                self.path, wanted="enough memory to read it", found=f"that {error.reason}",
                do="The file may be sound. Free memory, or start fewer processes at a time, then run again.",
            ) from error  # fmt: skip
        except DecoderFailed as error:
            do = "Export the file again, as CSV if need be."
            if error.limit is not None:
                setting = {"seconds": "max_seconds", "memory": "max_memory_mb"}[error.limit]
                do += (
                    f" If the file is sound, raise {setting} in the study's table [reading] (fit: --max-{error.limit})."
                )
            kind = RecordingError if error.limit == "memory" else PassingError
            raise kind(
                self.path, wanted=wanted, found=f"that {error.reason}", do=do,
            ) from error  # fmt: skip
        except Emg2vsaError:
            raise
        except ImportError as error:
            missing = isinstance(error, ModuleNotFoundError)
            other = self._reader.do and f" Or: {self._reader.do}"
            raise PassingError(
                self.path, wanted=f"the package {self._reader.library}, which reads {self._reader.format}",
                found=f"that it {'is not installed' if missing else 'cannot be imported'} ({said_by(error)})",
                do=f"Install it{'' if missing else ' again'}: {install_extra('formats')}.{other}",
            ) from error  # fmt: skip
        except Exception as error:  # a decoder may stumble over anything that a damaged file holds
            raise RecordingError(
                self.path, wanted=wanted, found=f"that its reader failed ({said_by(error)})",
                do="Export the file again, as CSV if need be.",
            ) from error  # fmt: skip


def inspect(path: Path, reading: ReadingSettings = _READING) -> tuple[str, tuple[ChannelInfo, ...]]:
    """Format and channels of a file. A channel whose rate the file does not let one know has ``fs_hz`` NaN."""
    name, opened = open_recording(path, reading)
    return name, opened.describe()


def read(path: Path, names: Sequence[str], reading: ReadingSettings = _READING) -> Recording:
    """The channels ``names`` of a file, at their native rates; voltages in V, forces in N, all else as stored.

    Missing samples stay NaN, with a note. Raises RecordingError for an unusable file, an unknown channel, or a channel
    asked for that is infinite anywhere or misses half of its samples.
    """
    name, opened = open_recording(path, reading)
    stored = load_named(opened, names)
    notes = (*opened.contents.notes, *(note for channel in stored for note in channel.notes))
    return Recording(Path(path), name, tuple(to_si(channel) for channel in stored), tuple(dict.fromkeys(notes)))


def load_named(
    opened: OpenRecording, names: Sequence[str], rates_hz: Sequence[float | None] = ()
) -> list[StoredChannel]:
    """The named channels as stored, each under the name it was asked by; checked as in ``usable``.

    rates_hz : of each name, Hz, for files that state none; () where nobody states any.
    RecordingError : no channel of a name, or one that cannot be used.
    """
    contents = opened.contents
    index = {**contents.aliases, **{known: i for i, known in enumerate(contents.names)}}
    for name in names:
        if name not in index:
            raise no_such_channel(opened.path, name, contents.names)
    stored = opened.load([index[name] for name in names])
    count("samples decoded", sum(channel.samples.size for channel in stored))
    return [
        usable(opened.path, name, channel, fs_hz)
        for name, channel, fs_hz in zip(names, stored, rates_hz or [None] * len(names), strict=True)
    ]
