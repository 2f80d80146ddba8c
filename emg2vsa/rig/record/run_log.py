"""The log of a run: a row per turn of the loop, as CSV, readable at any moment and after any end."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from emg2vsa.devices.protocols import ForceSample
from emg2vsa.durable.append_file import AppendFile
from emg2vsa.durable.writer import AT_ONCE, Writer
from emg2vsa.errors import RecordingError

GOING_IN = ("approach", "contact", "load")
"Phases in which the travel of the probe counts: the contact begins before the loading does."


class Row(NamedTuple):
    """One turn. None, an empty field, is what was not measured or not yet commanded."""

    time_s: float
    repetition: int
    phase: str
    force_time_s: float | None
    "When the reading of the force came; its age is what the turn's time is later."
    force_n: float | None
    "Along the rig's push_axis, as measured."
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
    "Last frame of the loading being recorded; -1 when there is none."
    # version 0.1.0 had no more than these
    late_s: float | None = None
    "From the turn's due time until it began; none while the probe is taken away after the end."
    fx_n: float | None = None
    "Force and torque in the axes of the sensor, of the same reading."
    fy_n: float | None = None
    fz_n: float | None = None
    tx_nm: float | None = None
    ty_nm: float | None = None
    tz_nm: float | None = None
    force_status: int | None = None
    "The sensor's status word."
    force_sequence: int | None = None
    "The sensor's number of the reading: the same again is the same reading."


FIELDS = Row._fields
HEADER = ",".join(FIELDS)
"""First line of a log."""
HEADERS = {HEADER: len(FIELDS), ",".join(FIELDS[:14]): 14}
"""First lines of logs that can be read, those of version 0.1.0 too, and how many fields a row then has."""
_OF_FORCE = FIELDS[FIELDS.index("fx_n") :]
_INTEGERS = {name for name in FIELDS if name.endswith(("_ticks", "_ma"))} | {
    "repetition", "frame_index", "force_status", "force_sequence",
}  # fmt: skip


class RunLog:
    """A new log. Each row goes to the system at once, so that not even kill -9 takes one.

    Nothing waits for the disk itself: that can take seconds, and the watchdog of the motors less than one. So a loss of
    power may take the newest rows.

    DeviceError, also from ``append``: the file is there already, or the disk is full.
    """

    def __init__(self, path: Path, writer: Writer = AT_ONCE) -> None:
        self.path, self.rows = path, 0
        self._file = AppendFile(path, writer)
        self._file.append(f"{HEADER}\n".encode())

    def append(self, row: Row) -> None:
        """Write it, in one piece."""
        self._file.append((_form(tuple(map(type, row))) % row).encode())
        self.rows += 1

    def close(self) -> None:
        """Give the file back."""
        self._file.close()


def full_force(sample: ForceSample) -> dict[str, Any]:
    """All that a reading says: the last fields of a row, from fx_n on."""
    return dict(zip(_OF_FORCE, loads_of(sample), strict=True))


def loads_of(sample: ForceSample) -> tuple[Any, ...]:
    """The same, as the last fields of a row."""
    return (*sample.loads, sample.status.code, sample.sequence)


def row_of(line: str, where: str, n_fields: int = len(FIELDS)) -> Row:
    """The row in a line of a log of so many fields; RecordingError, naming ``where``, if it is none."""
    try:
        named = zip(FIELDS[:n_fields], line.split(","), strict=True)
        return Row(*(_value(name, text) for name, text in named))  # type: ignore[arg-type]
    except ValueError as error:
        wanted, do = f"{n_fields} fields of a row", "Choose the log.csv of a run, unedited."
        raise RecordingError(where, wanted=wanted, found=repr(line), do=do) from error


class ForceFile:
    """A new file of all samples of the sensor in a run, not only the newest of each turn; else as `RunLog`."""

    def __init__(self, path: Path, writer: Writer = AT_ONCE) -> None:
        self._file = AppendFile(path, writer)
        self._file.append(f"time_s,{','.join(_OF_FORCE)}\n".encode())

    def append(self, samples: Sequence[ForceSample]) -> None:
        """Write them, oldest first."""
        rows = (",".join(map(_text, (sample.time_s, *loads_of(sample)))) + "\n" for sample in samples)
        if text := "".join(rows):
            self._file.append(text.encode())

    def close(self) -> None:
        """Give the file back."""
        self._file.close()


@lru_cache
def _form(types: tuple[type, ...]) -> str:
    """What makes a line of a row of values of these types."""
    parts = ("%.6f" if issubclass(each, float) else "%.0s" if each is type(None) else "%s" for each in types)
    return ",".join(parts) + "\n"


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
