"""The new rows of a log that is being written."""

from __future__ import annotations

from pathlib import Path
from typing import BinaryIO

from emg2vsa.errors import RecordingError
from emg2vsa.rig.record.run_log import FORMS, Row, row_of

_HEADS = {f"{header}\n".encode(): form for header, form in FORMS.items()}
_LONGEST_HEAD = max(map(len, _HEADS))
_NEWEST_BYTES = 700_000
"""A log that is long already is read from so far before its end: 15 s at 200 Hz and no more than 230 bytes a row."""


class LogTail:
    """Follows one log; only what was added since the last time is read.

    newest_bytes : how much of a log that is there already comes with the first rows.
    """

    def __init__(self, path: Path, newest_bytes: int = _NEWEST_BYTES) -> None:
        self._path, self._newest_bytes = path, newest_bytes
        self._read_bytes = 0
        self._form = next(iter(FORMS.values()))

    def new_rows(self) -> list[Row]:
        """Whole rows since the last call, oldest first; half a last line waits for its other half.

        Raises
        ------
        RecordingError : the file is no log of a run, or cannot be read.
        """
        try:
            with self._path.open("rb") as file:
                if self._read_bytes == 0:
                    self._read_bytes = self._start(file)
                file.seek(self._read_bytes)
                piece = file.read() if self._read_bytes else b""
        except FileNotFoundError:
            return []
        except OSError as error:
            raise self._unreadable(error.strerror or str(error)) from error
        whole = piece[: piece.rfind(b"\n") + 1]
        self._read_bytes += len(whole)
        lines = whole.decode("ascii", "replace").splitlines()
        return [row_of(line, str(self._path), *self._form) for line in lines]

    def modified_s(self) -> float | None:
        """When the log last grew, seconds since 1970; None before there is one."""
        try:
            return self._path.stat().st_mtime
        except OSError:
            return None

    def _start(self, file: BinaryIO) -> int:
        """Where the first row to be read begins; 0 while the header is not whole."""
        head = file.read(_LONGEST_HEAD)
        whole = head[: head.find(b"\n") + 1]
        if not whole and any(known.startswith(head) for known in _HEADS):
            return 0
        if whole not in _HEADS:
            raise self._unreadable(repr(head[:40].decode("ascii", "replace")))
        self._form = _HEADS[whole]
        size_bytes = file.seek(0, 2)
        if size_bytes <= len(whole) + self._newest_bytes:
            return len(whole)
        file.seek(size_bytes - self._newest_bytes)
        file.readline()  # most likely the rest of a row
        return file.tell()

    def _unreadable(self, found: str) -> RecordingError:
        do = "Choose the folder of a run, or of runs."
        return RecordingError(self._path, wanted="the log of a run", found=found, do=do)
