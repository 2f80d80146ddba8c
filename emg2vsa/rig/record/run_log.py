"""The log of a run: a row per turn of the loop, as CSV, readable at any moment and after any end."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from emg2vsa.errors import RecordingError
from emg2vsa.rig.record.append_file import AppendFile


class Row(NamedTuple):
    """One turn. None, an empty field, is what was not measured or not yet commanded."""

    time_s: float
    repetition: int
    phase: str
    force_time_s: float | None
    "When the reading of the force came; its age is what the turn's time is later."
    force_n: float | None
    filtered_n: float | None
    position_ticks: int | None
    "Commanded, as is the preset."
    preset_ticks: int | None
    motor_1_ticks: int | None
    motor_2_ticks: int | None
    "Under high-stiffness not connected: no part of position or preset."
    shaft_ticks: int | None
    "Under high-stiffness motor 1's."
    current_1_ma: int | None
    current_2_ma: int | None
    frame_index: int
    "Last frame saved of the loading being recorded; -1 when there is none."


HEADER = ",".join(Row._fields)
"""First line of a log."""
_INTEGERS = {name for name in Row._fields if name.endswith(("_ticks", "_ma")) or name in ("repetition", "frame_index")}


class RunLog:
    """A new log. Each row goes to the system at once, so that not even kill -9 takes one.

    Nothing waits for the disk itself: that can take seconds, and the watchdog of the motors less than one. So a loss of
    power may take the newest rows.

    DeviceError, also from ``append``: the file is there already, or the disk is full.
    """

    def __init__(self, path: Path) -> None:
        self.path, self.rows = path, 0
        self._file = AppendFile(path)
        self._file.append(f"{HEADER}\n".encode())

    def append(self, row: Row) -> None:
        """Write one row."""
        self._file.append((",".join(map(_text, row)) + "\n").encode())
        self.rows += 1

    def close(self) -> None:
        """Give the file back."""
        self._file.close()


def row_of(line: str, where: str) -> Row:
    """The row in a line of a log; RecordingError, naming ``where``, if it is none."""
    try:
        return Row(*(_value(n, text) for n, text in zip(Row._fields, line.split(","), strict=True)))  # type: ignore[arg-type]
    except ValueError as error:
        wanted, do = f"{len(Row._fields)} fields of a row", "Choose the log.csv of a run, unedited."
        raise RecordingError(where, wanted=wanted, found=repr(line), do=do) from error


def _value(name: str, text: str) -> str | float | int | None:
    if name == "phase":
        return text
    if not text:
        return None
    return int(text) if name in _INTEGERS else float(text)


def _text(value: str | float | int | None) -> str:
    if value is None:
        return ""
    return f"{value:.6f}" if isinstance(value, float) else str(value)
