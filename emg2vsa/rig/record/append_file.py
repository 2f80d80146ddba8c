"""A file that only grows, by whole pieces: whatever kills the program, what was appended stays readable."""

from __future__ import annotations

import os
from pathlib import Path

from emg2vsa.errors import DeviceError

_BINARY = getattr(os, "O_BINARY", 0)
"""Windows would write a carriage return before every line feed."""


class AppendFile:
    """A new file, in a folder that is made when missing.

    Each piece goes to the system at once and whole; a piece that does not fit is taken back. Safe against the
    end of the program, not against loss of power.

    Raises
    ------
    DeviceError : the file is there already or cannot be made.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | _BINARY, 0o666)
        except OSError as error:
            raise self._trouble(error) from error
        self.size_bytes = 0

    def append(self, piece: bytes) -> None:
        """Add a piece at the end. Raises DeviceError when the disk does not take all of it."""
        try:
            written = self._write(piece, self.size_bytes)
        except OSError as error:
            raise self._trouble(error) from error
        if written < len(piece):
            os.ftruncate(self._file, self.size_bytes)
            raise DeviceError(
                self.path,
                wanted=f"room for {len(piece)} bytes",
                found=f"room for {written}",
                do="Free some disk space; everything recorded before is whole.",
            )
        self.size_bytes += len(piece)

    def patch(self, offset: int, piece: bytes) -> None:
        """Overwrite a few bytes."""
        try:
            self._write(piece, offset)
        except OSError as error:
            raise self._trouble(error) from error

    def close(self) -> None:
        """Give the file back; a second time does nothing."""
        if self._file >= 0:
            os.close(self._file)
            self._file = -1

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
