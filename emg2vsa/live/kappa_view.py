"""What the page shows of kappa: the press that was judged last, from kappa.csv as it grows."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path

from emg2vsa.errors import RecordingError
from emg2vsa.rig.kappa.live_kappa import KAPPA_FILE, KappaRow, rows_of

Column = list[float | None]


@dataclass(frozen=True)
class KappaView:
    """The press that was judged last; columns of the frames that tell kappa, oldest first."""

    repetition: int
    presses: int
    "That count in the newest interval."
    force_n: Column = field(default_factory=list)
    kappa_n_per_mm: Column = field(default_factory=list)
    low_n_per_mm: Column = field(default_factory=list)
    high_n_per_mm: Column = field(default_factory=list)
    "None where the specimen may be rigid."
    half_width: float | None = None
    "Of the newest interval, as a share of kappa."
    amplification: float | None = None
    "Percent of kappa for 1 % of CASR."
    stop: str = ""
    "Why the press was stopped; empty for a whole one."
    stop_n: float | None = None
    "Force of the frame that was enough."
    note: str = ""


class KappaTail:
    """Follows kappa.csv of the run in ``folder``; only what was added since the last look is read."""

    def __init__(self, folder: Path) -> None:
        self._path, self._read_bytes = folder / KAPPA_FILE, 0
        self._rows: list[KappaRow] = []

    def look(self) -> KappaView | None:
        """None while no press is judged. RecordingError : the file is no kappa.csv."""
        for row in self._new_rows():
            if self._rows and self._rows[-1].repetition != row.repetition:
                self._rows = []
            self._rows.append(row)
        if not self._rows:
            return None
        told = [row for row in self._rows if math.isfinite(row.kappa_n_per_mm)]
        newest = told[-1] if told else self._rows[-1]
        enough = next((row for row in self._rows if row.stop), None)
        return KappaView(
            repetition=newest.repetition,
            presses=newest.presses,
            force_n=[_number(row.force_n) for row in told],
            kappa_n_per_mm=[_number(row.kappa_n_per_mm) for row in told],
            low_n_per_mm=[_number(row.low_n_per_mm) for row in told],
            high_n_per_mm=[_number(row.high_n_per_mm) for row in told],
            half_width=_number(newest.half_width),
            amplification=_number(newest.amplification),
            stop=enough.stop if enough else "",
            stop_n=_number(enough.force_n) if enough else None,
            note=newest.note,
        )

    def _new_rows(self) -> list[KappaRow]:
        try:
            with self._path.open("rb") as file:
                file.seek(self._read_bytes)
                piece = file.read()
        except FileNotFoundError:
            return []
        except OSError as error:
            raise self._unreadable(error.strerror or str(error)) from error
        whole = piece[: piece.rfind(b"\n") + 1]
        text = whole.decode("utf-8", "replace")
        if self._read_bytes == 0:
            text = text[text.find("\n") + 1 :]
        try:
            rows = rows_of(text)
        except ValueError as error:
            raise self._unreadable(str(error)) from error
        self._read_bytes += len(whole)
        return rows

    def _unreadable(self, found: str) -> RecordingError:
        return RecordingError(
            self._path, wanted="rows of kappa", found=found, do="Choose the folder of a run, or of runs."
        )


def _number(value: float) -> float | None:
    return float(f"{value:.5g}") if math.isfinite(value) else None
