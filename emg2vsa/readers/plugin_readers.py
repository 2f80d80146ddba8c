"""Readers of other installed packages: entry points of ``emg2vsa.readers``, each an object with three names.

``name`` is the format; ``sniff(path, head)`` says whether a file is of it, from its name and first 4096 bytes; and
``open_recording(path)`` returns an `OpenRecording` (``emg2vsa.readers.opened``) or raises RecordingError. They are
asked about files whose content no reader of this project knows, which is so of texts too: they come before our two
readers of any text, and after all others. What they return and raise is looked at, so that a fault of one is told as
its own and stops no file that another reader reads.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from casr.errors import PluginError, said_by
from casr.plugins import Plugin, plugins
from emg2vsa.errors import Emg2vsaError, RecordingError
from emg2vsa.readers.opened import Contents, OpenRecording, StoredChannel
from emg2vsa.recordings import ChannelInfo

_OFFERED = {"name": str, "sniff": object, "open_recording": object}


def plugin_reader(path: Path, head: bytes) -> tuple[PluginReader | None, tuple[str, ...]]:
    """The first reader that says the file is of its format, and what is wrong with readers that could not be asked."""
    faults: list[str] = []
    for plugin in plugins("emg2vsa.readers"):
        try:
            reader = PluginReader(plugin)
            if reader.sniff(path, head):
                return reader, tuple(faults)
        except PluginError as fault:
            faults.append(str(fault))
    return None, tuple(faults)


class PluginReader:
    """A reader of another package. PluginError where it cannot be imported or lacks what a reader offers."""

    def __init__(self, plugin: Plugin) -> None:
        self.plugin, self._reader = plugin, plugin.load()
        for name, kind in _OFFERED.items():
            found = getattr(self._reader, name, None)
            if not (callable(found) if kind is object else isinstance(found, kind)):
                raise plugin.fault("a reader with name (text), sniff(path, head), open_recording(path)", f"no {name}")
        self.format: str = self._reader.name

    def sniff(self, path: Path, head: bytes) -> bool:
        """Whether the file is of the reader's format. PluginError : it failed to say."""
        try:
            return bool(self._reader.sniff(path, head))
        except Exception as error:  # of foreign code
            raise self.plugin.fault("sniff to say whether a file is of its format", said_by(error)) from error

    def open(self, path: Path) -> OpenRecording:
        """The opened file. RecordingError where the reader refuses it, fails, or breaks its contract."""
        with self.faults(path):
            opened = self._reader.open_recording(path)
            return OpenByPlugin(self, path, opened, opened.contents)

    @contextmanager
    def faults(self, path: Path) -> Iterator[None]:
        """Whatever the reader's code raises comes out as an error of this project that names the reader."""
        try:
            yield
        except Emg2vsaError:
            raise
        except Exception as error:  # of foreign code, which may stumble over anything
            raise self.broken(path, said_by(error)) from error

    def broken(self, path: Path, found: str) -> RecordingError:
        return RecordingError(
            path, wanted=f"{self.format} data that the reader {self.plugin} can read",
            found=f"that it failed ({found})",
            do=f"See that the file is sound, tell the authors of {self.plugin.distribution}, or uninstall it.",
        )  # fmt: skip


@dataclass
class OpenByPlugin:
    """A file that the reader of another package holds open. A note says whose it is."""

    reader: PluginReader
    path: Path
    opened: Any
    contents: Contents

    def __post_init__(self) -> None:
        if not isinstance(self.contents, Contents) or not all(isinstance(name, str) for name in self.contents.names):
            raise self.reader.broken(self.path, "contents is no Contents with names")
        note = f"read by the reader {self.reader.plugin}"
        self.contents = replace(self.contents, notes=(*self.contents.notes, note))

    def describe(self) -> tuple[ChannelInfo, ...]:
        """Facts on each channel. RecordingError : the reader failed, or gave others."""
        with self.reader.faults(self.path):
            found = tuple(self.opened.describe())
            if len(found) != len(self.contents.names) or not all(isinstance(one, ChannelInfo) for one in found):
                raise self.reader.broken(self.path, "describe gave no ChannelInfo for each channel")
            return found

    def load(self, indices: Sequence[int]) -> list[StoredChannel]:
        """Samples of these channels. RecordingError : the reader failed, or gave other than (n,) float64 for each."""
        with self.reader.faults(self.path):
            found = list(self.opened.load(indices))
            if len(found) != len(indices) or not all(map(_is_channel, found)):
                raise self.reader.broken(self.path, "load gave no StoredChannel of (n,) float64 for each index")
            return found


@dataclass
class Noted:
    """A file opened by our own reader, with notes on readers of other packages that could not be asked about it."""

    opened: OpenRecording
    faults: tuple[str, ...]

    def __post_init__(self) -> None:
        self.path = self.opened.path
        self.contents = replace(self.opened.contents, notes=(*self.opened.contents.notes, *self.faults))
        self.describe, self.load = self.opened.describe, self.opened.load


def _is_channel(found: object) -> bool:
    samples = getattr(found, "samples", None)
    return (
        isinstance(found, StoredChannel)
        and isinstance(samples, np.ndarray)
        and samples.ndim == 1
        and samples.dtype == np.float64
    )
