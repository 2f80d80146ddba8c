"""A file that only grows, by whole pieces: whatever kills the program, what was appended stays readable."""

from __future__ import annotations

import contextlib
from pathlib import Path

from emg2vsa.durable.writer import AT_ONCE, Writer
from emg2vsa.errors import DeviceError


class AppendFile:
    """A new file, in a folder that is made when missing.

    Each piece goes to the system whole, when ``writer`` comes to it; a piece that does not fit is taken back, and none
    is added after it. Safe against the end of the program, not against loss of power.

    Raises
    ------
    DeviceError : the file is there already or cannot be made.
    """

    def __init__(self, path: Path, writer: Writer = AT_ONCE) -> None:
        self.path, self.size_bytes = path, 0
        self._writer, self._system = writer, writer.system
        self._handle, self._full = -1, False
        writer.do(self._open)

    def append(self, piece: bytes) -> None:
        """Add a piece at the end. Raises DeviceError when the disk does not take all of it."""
        offset = self.size_bytes
        self.size_bytes += len(piece)
        self._writer.do(self._append, offset, piece)

    def patch(self, offset: int, piece: bytes) -> None:
        """Overwrite a few bytes."""
        self._writer.do(self._patch, offset, piece)

    def close(self) -> None:
        """Give the file back; a second time does nothing."""
        self._writer.do(self._close)

    def _open(self) -> None:
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._handle = self._system.create(self.path)
        except OSError as error:
            raise self._trouble(error) from error

    def _append(self, offset: int, piece: bytes) -> None:
        if self._full:
            raise self._no_room(len(piece), 0)
        try:
            self._system.write(self._handle, offset, piece)
        except OSError as error:
            self._full = True
            taken = 0
            with contextlib.suppress(OSError):
                taken = self.path.stat().st_size - offset
                self._system.truncate(self._handle, offset)
            raise (self._no_room(len(piece), taken) if taken > 0 else self._trouble(error)) from error

    def _patch(self, offset: int, piece: bytes) -> None:
        if self._full:  # what was to be patched is not there
            return
        try:
            self._system.write(self._handle, offset, piece)
        except OSError as error:
            raise self._trouble(error) from error

    def _close(self) -> None:
        if self._handle >= 0:
            self._system.close(self._handle)
            self._handle = -1

    def _no_room(self, wanted: int, found: int) -> DeviceError:
        return DeviceError(
            self.path, wanted=f"room for {wanted} bytes", found=f"room for {found}",
            do="Free some disk space; everything recorded before is whole.",
        )  # fmt: skip

    def _trouble(self, error: OSError) -> DeviceError:
        return DeviceError(
            self.path, wanted="a new file to record to", found=error.strerror or str(error),
            do="Check the folder, its permissions and the disk.",
        )  # fmt: skip
