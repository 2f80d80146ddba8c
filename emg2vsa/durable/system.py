"""The calls of the operating system that a recording makes: an argument, so that a test can fill the disk or cut the
power."""

from __future__ import annotations

import errno
import os
from pathlib import Path

from casr.atomic import sync_folder

_BINARY = getattr(os, "O_BINARY", 0)
"""Windows would write a carriage return before every line feed."""


PRIVATE = 0o600
"""Mode of a file that other users do not read."""


class OperatingSystem:
    """The real one. Each call raises OSError where the disk refuses."""

    def open(self, path: Path) -> int:
        """Open a file for writing, made for this user alone where it is missing; its folder is known to the disk itself
        afterwards."""
        handle = os.open(path, os.O_RDWR | os.O_CREAT | _BINARY, PRIVATE)
        sync_folder(path.parent)
        return handle

    def create(self, path: Path) -> int:
        """Open a new file for writing, and wait for nothing. OSError where it is there already."""
        return os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | _BINARY, 0o666)

    def write(self, handle: int, offset: int, piece: bytes) -> None:
        """Write all of a piece. OSError where the disk does not take all of it; some of it may be in the file then."""
        if hasattr(os, "pwrite"):
            taken: int = os.pwrite(handle, piece, offset)
        else:  # Windows: two calls instead of one, and nobody else has this file
            os.lseek(handle, offset, os.SEEK_SET)
            taken = os.write(handle, piece)
        if taken < len(piece):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def truncate(self, handle: int, size: int) -> None:
        """Cut a file."""
        os.ftruncate(handle, size)

    def sync(self, handle: int) -> None:
        """Return when what was written to a file has reached the disk itself."""
        os.fsync(handle)

    def close(self, handle: int) -> None:
        """Give a file back."""
        os.close(handle)


SYSTEM = OperatingSystem()
