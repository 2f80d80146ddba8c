"""A file that only grows, by whole pieces: whatever kills the program, what was appended stays readable."""

from __future__ import annotations

import os
from pathlib import Path

from emg2vsa.errors import DeviceError
from emg2vsa.rig.record.disk import AT_ONCE, Disk

_BINARY = getattr(os, "O_BINARY", 0)
"""Windows would write a carriage return before every line feed."""


class AppendFile:
    """A new file, in a folder that is made when missing.

    Each piece goes to the system whole, at once or when ``disk`` comes to it; a piece that does not fit is taken back,
    and none is added after it. Safe against the end of the program, not against loss of power.

    Raises
    ------
    DeviceError : the file is there already or cannot be made.
    """

    def __init__(self, path: Path, disk: Disk = AT_ONCE) -> None:
        self.path, self.size_bytes = path, 0
        self._disk, self._file, self._full = disk, -1, False
        disk.do(self._open)

    def append(self, piece: bytes) -> None:
        """Add a piece at the end. Raises DeviceError when the disk does not take all of it."""
        offset = self.size_bytes
        self.size_bytes += len(piece)
        self._disk.do(lambda: self._append(piece, offset))

    def patch(self, offset: int, piece: bytes) -> None:
        """Overwrite a few bytes."""
        self._disk.do(lambda: self._patch(offset, piece))

    def close(self) -> None:
        """Give the file back; a second time does nothing."""
        self._disk.do(self._close)

    def _open(self) -> None:
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._file = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_EXCL | _BINARY, 0o666)
        except OSError as error:
            raise self._trouble(error) from error

    def _append(self, piece: bytes, offset: int) -> None:
        if self._full:
            raise self._no_room(len(piece), 0)
        try:
            written = self._write(piece, offset)
        except OSError as error:
            self._full = True
            raise self._trouble(error) from error
        if written < len(piece):
            self._full = True
            os.ftruncate(self._file, offset)
            raise self._no_room(len(piece), written)

    def _patch(self, offset: int, piece: bytes) -> None:
        if self._full:  # what was to be patched is not there
            return
        try:
            self._write(piece, offset)
        except OSError as error:
            raise self._trouble(error) from error

    def _close(self) -> None:
        if self._file >= 0:
            os.close(self._file)
            self._file = -1

    def _no_room(self, wanted: int, found: int) -> DeviceError:
        return DeviceError(
            self.path,
            wanted=f"room for {wanted} bytes",
            found=f"room for {found}",
            do="Free some disk space; everything recorded before is whole.",
        )

    def _write(self, piece: bytes, offset: int) -> int:
        """Bytes written."""
        if hasattr(os, "pwrite"):
            written: int = os.pwrite(self._file, piece, offset)
            return written
        # Windows: two calls instead of one, and nobody else has this file
        os.lseek(self._file, offset, os.SEEK_SET)
        return os.write(self._file, piece)

    def _trouble(self, error: OSError) -> DeviceError:
        return DeviceError(
            self.path,
            wanted="a new file to record to",
            found=error.strerror or str(error),
            do="Check the folder, its permissions and the disk.",
        )
