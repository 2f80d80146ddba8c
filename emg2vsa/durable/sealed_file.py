"""A file that only grows, and keeps what is not on the disk itself until it is: no loss of power takes what is sealed.

What a disk refuses (full, unplugged) is written again when it takes it, with all that came since the last seal: after a
failed fsync the system may have dropped the pages. So nothing is damaged, and nothing is lost that still fits into
memory.
"""

from __future__ import annotations

import contextlib
from pathlib import Path

from emg2vsa.durable.writer import Writer
from emg2vsa.errors import DeviceError

_SEAL_BYTES = 1_000_000
"""Pieces are brought to the disk itself after so many bytes, if no line asks for it sooner."""


class SealedFile:
    """A file made where it is missing, or opened to grow on; the folder is made when missing. Waits a moment.

    whole_bytes : what is whole of a file that is there; a torn end after it is cut off. None: all of it.

    Raises
    ------
    DeviceError : the folder does not take it.
    """

    def __init__(self, path: Path, writer: Writer, whole_bytes: int | None = None) -> None:
        self.path, self.pending_bytes = path, 0
        "``pending_bytes``: what is not yet on the disk itself, of what the writer has come to."
        self._writer, self._system = writer, writer.system
        self._pending: list[bytes] = []
        self._written_bytes = 0
        "Bytes of ``_pending`` that the system has taken."
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._handle = self._system.open(path)
            self._sealed_bytes = path.stat().st_size
            if whole_bytes is not None and whole_bytes < self._sealed_bytes:
                self._system.truncate(self._handle, whole_bytes)
                self._system.sync(self._handle)
                self._sealed_bytes = whole_bytes
        except OSError as error:
            raise DeviceError(
                path, wanted="a file to record to", found=error.strerror or str(error),
                do="Check the folder, its permissions and the disk.",
            ) from error  # fmt: skip
        writer.sealed_files.append(self)

    def append(self, piece: bytes) -> bool:
        """Add a piece; never waits. False where it was given up, because too much waits for a disk that refuses."""
        return self._writer.keep(self._append, piece)

    def seal(self, line: bytes) -> None:
        """Add a line after everything that was appended before, to any file, has reached the disk itself."""
        self._writer.seal(self._append_line, line)

    def write_all(self) -> None:
        """Write what is pending, and wait for the disk itself. OSError where it does not take all."""
        self._write()
        if self._pending:
            try:
                self._system.sync(self._handle)
            except OSError:
                self._written_bytes = 0
                raise
            self._sealed_bytes += self.pending_bytes
            self._pending, self.pending_bytes, self._written_bytes = [], 0, 0

    def close(self) -> None:
        """Give the file back."""
        self._system.close(self._handle)

    def _append(self, piece: bytes) -> None:
        self._pending.append(piece)
        self.pending_bytes += len(piece)
        if self.pending_bytes >= _SEAL_BYTES:
            self.write_all()
        else:
            self._write()

    def _append_line(self, line: bytes) -> None:
        """A line that is refused waits with the writer, which writes the samples before it first."""
        self._pending, self.pending_bytes = [line], len(line)
        try:
            self.write_all()
        except OSError:
            self._pending, self.pending_bytes, self._written_bytes = [], 0, 0
            raise

    def _write(self) -> None:
        """Give the system what it has not taken; where it does not take all, no part of that stays in the file."""
        if self._written_bytes == self.pending_bytes:
            return
        offset = self._sealed_bytes + self._written_bytes
        content = self._pending[-1] if self._written_bytes else b"".join(self._pending)
        try:
            self._system.write(self._handle, offset, content)
        except OSError:
            with contextlib.suppress(OSError):  # the next attempt writes over what stays
                self._system.truncate(self._handle, offset)
            raise
        self._written_bytes = self.pending_bytes
