"""The log of a run: a row per turn of the loop, as CSV, readable at any moment and after any end."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from emg2vsa.devices.protocols import ForceSample, LogColumns, Measurements
from emg2vsa.devices.qbmove.ticks import LOG_COLUMNS
from emg2vsa.durable.append_file import AppendFile
from emg2vsa.durable.writer import AT_ONCE, Writer
from emg2vsa.errors import RecordingError

if TYPE_CHECKING:
    import pandas as pd

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
    position_deg: float | None
    "Commanded, as is the preset."
    preset: float | None
    "In the unit of a full preset: springs degrees, a gain N m/rad."
    at: Measurements | None = None
    "Under high-stiffness motor 2 is not connected, and no part of position or preset; the shaft is motor 1's."
    currents_a: tuple[float, ...] = ()
    frame_index: int = -1
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


_FIELDS = Row._fields
_BEFORE, _AFTER = _FIELDS.index("position_deg"), _FIELDS.index("frame_index")
_OF_FORCE = _FIELDS[_FIELDS.index("fx_n") :]
_KNOWN = (LogColumns(), LOG_COLUMNS)
"""Columns of logs that can be read: of every actuator, and of a qbmove."""
_SHAFTS = {columns.names[4]: columns.per_degree for columns in _KNOWN}
_NONE = None, None
_UNSEEN: tuple[tuple[float, ...], None] = (), None
_INTEGERS = {"repetition", "frame_index", "force_status", "force_sequence"}


def header_of(columns: LogColumns) -> tuple[str, ...]:
    """Names in the first line of a log."""
    return (*_FIELDS[:_BEFORE], *columns.names, *_FIELDS[_AFTER:])


FORMS = {
    ",".join(header[:n_fields]): (columns, n_fields)
    for columns in _KNOWN
    for header in [header_of(columns)]
    for n_fields in (len(header), header.index("frame_index") + 1)
}
"""First line of a log that can be read, those of version 0.1.0 too, to its columns and how many fields a row has."""


class RunLog:
    """A new log. Each row goes to the system at once, so that not even kill -9 takes one.

    Nothing waits for the disk itself: that can take seconds, and the watchdog of the motors less than one. So a loss of
    power may take the newest rows.

    DeviceError, also from ``append``: the file is there already, or the disk is full.
    """

    def __init__(self, path: Path, columns: LogColumns, writer: Writer = AT_ONCE) -> None:
        self.path, self.rows, self._columns = path, 0, columns
        self._as_written: Callable[[float], float | int] = round if columns.whole else float
        self._types, self._form = list[type](), ""
        self._file = AppendFile(path, writer)
        self._file.append((",".join(header_of(columns)) + "\n").encode())

    def append(self, row: Row) -> None:
        """Write it, in one piece."""
        values = row[:_BEFORE] + self._of_actuator(row) + row[_AFTER:]
        types = list(map(type, values))
        if types != self._types:  # of most rows as of the one before
            self._types, self._form = types, _form(types)
        self._file.append((self._form % values).encode())
        self.rows += 1

    def close(self) -> None:
        """Give the file back."""
        self._file.close()

    def _of_actuator(self, row: Row) -> tuple[float | int | None, ...]:
        (_, per_degree, per_preset, per_ampere, _), as_written = self._columns, self._as_written
        motors_deg, shaft_deg = row.at or _UNSEEN
        position_deg, preset = row.position_deg, row.preset
        motors = [as_written(motor_deg * per_degree) for motor_deg in motors_deg[:2]]
        currents = [as_written(current_a * per_ampere) for current_a in row.currents_a[:2]]
        return (
            None if position_deg is None else as_written(position_deg * per_degree),
            None if preset is None else as_written(preset * per_preset),
            *motors, *_NONE[len(motors) :],
            None if shaft_deg is None else as_written(shaft_deg * per_degree),
            *currents, *_NONE[len(currents) :],
        )  # fmt: skip


def loads_of(sample: ForceSample) -> tuple[Any, ...]:
    """All that a reading says, as the last fields of a row, from fx_n on."""
    return (*sample.loads, sample.status.code, sample.sequence)


def row_of(line: str, where: str, columns: LogColumns, n_fields: int) -> Row:
    """The row in a line of a log of these columns and so many fields; RecordingError, naming ``where``, else."""
    names = header_of(columns)[:n_fields]
    try:
        cells = {name: _value(name, text) for name, text in zip(names, line.split(","), strict=True)}
    except ValueError as error:
        wanted, do = f"{n_fields} fields of a row", "Choose the log.csv of a run, unedited."
        raise RecordingError(where, wanted=wanted, found=repr(line), do=do) from error
    first = names.index(columns.names[0])
    values: list[Any] = list(cells.values())
    position, preset, motor_1, motor_2, shaft, *currents = values[first : first + len(columns.names)]
    motors_deg = tuple(each / columns.per_degree for each in (motor_1, motor_2) if each is not None)
    own: dict[str, Any] = {name: cells[name] for name in names if name in _FIELDS} | {
        "position_deg": None if position is None else position / columns.per_degree,
        "preset": None if preset is None else preset / columns.per_preset,
        "at": None if shaft is None else Measurements(motors_deg, shaft / columns.per_degree),
        "currents_a": tuple(each / columns.per_ampere for each in currents if each is not None),
    }
    return Row(**own)


def read_log(path: Path, columns: Sequence[str] | None = None) -> pd.DataFrame:
    """These columns of a log, or all, damaged rows left out, and ``shaft_deg``, the angle of the shaft.

    OSError, ValueError : the file cannot be read. KeyError : it is no log."""
    import pandas as pd  # noqa: PLC0415  (who only records does without)

    chosen = None if columns is None else lambda name: name in columns or name in _SHAFTS
    log = pd.read_csv(path, on_bad_lines="skip", usecols=chosen)
    shaft = next((name for name in _SHAFTS if name in log.columns), "shaft_deg")
    shaft_deg = log[shaft] / _SHAFTS[shaft]
    return log[list(log.columns if columns is None else columns)].assign(shaft_deg=shaft_deg)


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


def _form(types: Sequence[type]) -> str:
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
