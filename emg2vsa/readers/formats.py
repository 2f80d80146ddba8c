"""The known formats: how a file of each is recognised by its name and first bytes, and the module that reads it.

The table is tried from top to bottom. Nothing here imports a reader, so a program may ask which one it would be.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from emg2vsa.readers import recognise


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


def reader_module(path: Path) -> str | None:
    """Name of the module that would open the file; None where it is absent, empty or of no known format.

    Reads the first bytes only and imports nothing.
    """
    try:
        head = head_of(Path(path))
    except OSError:
        return None
    reader = reader_of(Path(path), head) if head else None
    return reader.module if reader else None


def head_of(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(recognise.HEAD_BYTES)


def reader_of(path: Path, head: bytes) -> Reader | None:
    return next((reader for reader in READERS if reader.matches(path, head)), None)
