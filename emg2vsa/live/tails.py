"""The new rows of files that are being written: the log of a run, and what its presses told of kappa."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

from emg2vsa.errors import RecordingError
from emg2vsa.rig.kappa.live_kappa import KAPPA_FILE, KappaRow, rows_of
from emg2vsa.rig.record.run_log import FORMS, Row, row_of

_HEADS = {f"{header}\n".encode(): form for header, form in FORMS.items()}
_LONGEST_HEAD = max(map(len, _HEADS))
_NEWEST_BYTES = 700_000
"""A log that is long already is read from so far before its end: 15 s at 200 Hz and no more than 230 bytes a row."""
Column = list[float | None]


class _Tail:
    """A file of which only what was added since the last time is read. wanted : what it is, in words."""

    def __init__(self, path: Path, wanted: str) -> None:
        self._path, self._wanted, self._read_bytes = path, wanted, 0

    def _new_text(self) -> str:
        """Whole lines since the last call; half a last line waits for its other half. Nothing before there is a file.

        RecordingError : it cannot be read.
        """
        try:
            with self._path.open("rb") as file:
                start = self._read_bytes or self._start(file)
                if start is None:
                    return ""
                file.seek(start)
                piece = file.read()
        except FileNotFoundError:
            return ""
        except OSError as error:
            raise self._unreadable(error.strerror or str(error)) from error
        whole = piece[: piece.rfind(b"\n") + 1]
        self._read_bytes = start + len(whole)
        return whole.decode("utf-8", "replace")

    def _start(self, file: BinaryIO) -> int | None:
        """Where the first row to be read begins; None while the header is not whole."""
        head = file.readline()
        return len(head) if head.endswith(b"\n") else None

    def _unreadable(self, found: str) -> RecordingError:
        do = "Choose the folder of a run, or of runs."
        return RecordingError(self._path, wanted=self._wanted, found=found, do=do)


class LogTail(_Tail):
    """Follows one log. newest_bytes : how much of a log that is there already comes with the first rows."""

    def __init__(self, path: Path, newest_bytes: int = _NEWEST_BYTES) -> None:
        super().__init__(path, "the log of a run")
        self._newest_bytes = newest_bytes
        self._form = next(iter(FORMS.values()))

    def new_rows(self) -> list[Row]:
        """Whole rows since the last call, oldest first. RecordingError : it is no log of a run, or cannot be read."""
        return [row_of(line, str(self._path), *self._form) for line in self._new_text().splitlines()]

    def modified_s(self) -> float | None:
        """When the log last grew, seconds since 1970; None before there is one."""
        try:
            return self._path.stat().st_mtime
        except OSError:
            return None

    def _start(self, file: BinaryIO) -> int | None:
        head = file.read(_LONGEST_HEAD)
        whole = head[: head.find(b"\n") + 1]
        if not whole and any(known.startswith(head) for known in _HEADS):
            return None
        if whole not in _HEADS:
            raise self._unreadable(repr(head[:40].decode("ascii", "replace")))
        self._form = _HEADS[whole]
        size_bytes = file.seek(0, 2)
        if size_bytes <= len(whole) + self._newest_bytes:
            return len(whole)
        file.seek(size_bytes - self._newest_bytes)
        file.readline()  # most likely the rest of a row
        return file.tell()


@dataclass(frozen=True)
class KappaView:
    """The press that was judged last; columns of the frames that tell kappa, oldest first."""

    repetition: int
    presses: int
    "Presses that count in the newest interval."
    force_n: Column = field(default_factory=list)
    kappa_n_per_mm: Column = field(default_factory=list)
    low_n_per_mm: Column = field(default_factory=list)
    high_n_per_mm: Column = field(default_factory=list)
    "None where the specimen may be rigid."
    half_width: float | None = None
    "Half width of the newest interval, as a share of kappa."
    stop: str = ""
    "Why the press was stopped; empty for a whole one."
    stop_n: float | None = None
    "Force of the frame that was enough."
    note: str = ""


class KappaTail(_Tail):
    """Follows kappa.csv of the run in ``folder``."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder / KAPPA_FILE, "rows of kappa")
        self._rows: list[KappaRow] = []

    def look(self) -> KappaView | None:
        """None while no press is judged. RecordingError : the file is no kappa.csv, or cannot be read."""
        before_bytes = self._read_bytes
        try:
            rows = rows_of(self._new_text())
        except ValueError as error:
            self._read_bytes = before_bytes  # it is said as long as the page is looked at
            raise self._unreadable(str(error)) from error
        for row in rows:
            if self._rows and self._rows[-1].repetition != row.repetition:
                self._rows = []
            self._rows.append(row)
        if not self._rows:
            return None
        told = [row for row in self._rows if math.isfinite(row.kappa_n_per_mm)]
        newest = told[-1] if told else self._rows[-1]
        enough = next((row for row in self._rows if row.stop), None)
        columns = ("force_n", "kappa_n_per_mm", "low_n_per_mm", "high_n_per_mm")
        return KappaView(
            repetition=newest.repetition,
            presses=newest.presses,
            **{name: [_number(getattr(row, name)) for row in told] for name in columns},
            half_width=_number(newest.half_width),
            stop=enough.stop if enough else "",
            stop_n=_number(enough.force_n) if enough else None,
            note=newest.note,
        )


def _number(value: float) -> float | None:
    return float(f"{value:.5g}") if math.isfinite(value) else None
