"""Text tables whose channels are columns: each with a clock of its own, a shared one, or a rate the file states."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import RecordingError
from emg2vsa.readers.cells import Body
from emg2vsa.readers.opened import Contents, StoredChannel
from emg2vsa.readers.time_stamps import seconds_of
from emg2vsa.readers.timing import even_clock
from emg2vsa.recordings import ChannelInfo

_RATE_TOLERANCE = 1e-3
_SLOWEST_UNSTATED_HZ = 2.0
"""A time without a unit is believed to be in seconds only above this rate: slower ones are counts or milliseconds."""
_REPEATING = 0.02
"""Fewer repeated stamps are repeated rows and no rounding."""

_ENOUGH = 100
"""Stamps by which the one is told from the other."""

Cells = Mapping[int, NDArray[np.float64]]


@dataclass(frozen=True)
class Column:
    """One channel of a table.

    index, time_index : columns of samples and of time stamps (None: no stamps). time_unit_s : seconds in one unit of
    time; None where the file does not say (then seconds, if that gives a believable rate).
    fs_hz : the rate the file states. start_s : start it states. expected : number of samples it states.
    digits : significant digits of the time stamps, where the format is known to round them.
    decimals : digits behind the point that the time stamps are written with, where that was looked at.
    scale : ``unit`` in one stored number. stamped : the time is written with a date or as a time of day.
    notes : about the channel as such.
    """

    name: str
    unit: str | None
    index: int
    time_index: int | None = None
    time_unit_s: float | None = 1.0
    fs_hz: float | None = None
    start_s: float = 0.0
    expected: int | None = None
    digits: int | None = None
    decimals: int | None = None
    scale: float = 1.0
    stamped: bool = False
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class TimedColumns:
    """An opened text table."""

    path: Path
    contents: Contents
    body: Body
    columns: tuple[Column, ...]
    shared_length: bool = False
    "True where a channel that ends before the others deserves a note."

    def describe(self) -> tuple[ChannelInfo, ...]:
        cells, clocks = self._cells(self.columns), _Clocks({})
        return tuple(self._info(column, cells, clocks) for column in self.columns)

    def load(self, indices: Sequence[int]) -> list[StoredChannel]:
        asked = [self.columns[i] for i in indices]
        cells, clocks = self._cells(asked), _Clocks({})
        return [self._channel(column, cells, clocks) for column in asked]

    def _info(self, column: Column, cells: Cells, clocks: _Clocks) -> ChannelInfo:
        try:
            channel = self._channel(column, cells, clocks)
        except RecordingError:  # it is said in full when the channel is asked for
            return ChannelInfo(column.name, column.unit, float("nan"), _filled(cells[column.index]))
        return ChannelInfo(column.name, column.unit, channel.fs_hz, channel.samples.size)

    def _cells(self, asked: Sequence[Column]) -> Cells:
        names = {column.index: column.name for column in asked}
        names |= {c.time_index: f"time of {c.name}" for c in asked if c.time_index is not None and not c.stamped}
        stamped = {c.time_index: f"time of {c.name}" for c in asked if c.time_index is not None and c.stamped}
        cells = self.body.columns(names)
        for index, name in stamped.items():
            where = f"{self.path}, column {name!r}"
            cells[index] = seconds_of(self.body.texts(index), where, self.body.line)
        return cells

    def _channel(self, column: Column, cells: Cells, clocks: _Clocks) -> StoredChannel:
        samples = cells[column.index]
        n = _filled(samples)
        notes = list(column.notes)
        fs_hz, start_s = column.fs_hz or float("nan"), column.start_s
        if column.time_index is not None:
            time = cells[column.time_index]
            n = _without_zero_padding(time, n) if column.digits is not None else n
            if n:
                fs_hz, start_s = clocks.of(column, time[:n], f"{self.path}, time of {column.name!r}", self.body.line)
                notes += ["The time column states no unit; seconds were taken."] if column.time_unit_s is None else []
            if self.shared_length and n < (rows := _filled(time)):
                notes.append(f"{column.name}: ends after {n} of {rows} rows; blank cells were cut.")
        if column.expected is not None and column.expected != n:
            notes.append(f"{column.name}: the header promises {column.expected} samples, the file holds {n}.")
        return StoredChannel(column.name, samples[:n] * column.scale, column.unit, fs_hz, start_s, tuple(notes))


@dataclass(frozen=True)
class _Clocks:
    """Rates and starts measured so far, by time column and length: channels that share one share the work."""

    measured: dict[tuple[int | None, int], tuple[float, float]]

    def of(
        self, column: Column, time: NDArray[np.float64], where: str, place: Callable[[int], str]
    ) -> tuple[float, float]:
        """(rate, start) of a column; the rate its file states goes before the measured one, which must agree."""
        key = (column.time_index, time.size)
        if key not in self.measured:
            time_s = time * (column.time_unit_s or 1.0)
            rounding_s = _resolution(time_s, column.digits) or _rounding(time_s, column)
            self.measured[key] = even_clock(time_s, where, place, rounding_s)
        fs_hz, start_s = self.measured[key]
        if column.time_unit_s is None and fs_hz <= _SLOWEST_UNSTATED_HZ:
            raise RecordingError(
                where, wanted="a time unit", found=f"none, and a step of {1 / fs_hz:g}",
                do='Write it in the header, like "time (ms)"; a plain count of samples is no time.',
            )  # fmt: skip
        if column.fs_hz is not None and abs(column.fs_hz - fs_hz) > _RATE_TOLERANCE * column.fs_hz:
            raise RecordingError(
                where, wanted=f"the stated rate, {column.fs_hz:g} Hz", found=f"{fs_hz:g} Hz by the time stamps",
                do="Export the recording again; header and time disagree.",
            )  # fmt: skip
        return column.fs_hz or fs_hz, start_s


def _filled(samples: NDArray[np.float64]) -> int:
    """Length without the blank cells at the end."""
    filled = np.flatnonzero(~np.isnan(samples[::-1]))
    return samples.size - int(filled[0]) if filled.size else 0


def _without_zero_padding(time: NDArray[np.float64], n: int) -> int:
    """Length without the rows some exports fill up with time 0."""
    later = np.flatnonzero(time[:n])
    return min(n, int(later[-1]) + 1) if later.size else n


def _resolution(time_s: NDArray[np.float64], digits: int | None) -> float:
    """Rounding of the largest stamp written with that many significant digits."""
    largest = float(np.nanmax(np.abs(time_s))) if time_s.size else 0.0
    return 10.0 ** (np.floor(np.log10(largest)) + 1 - digits) if digits is not None and largest > 0 else 0.0


def _rounding(time_s: NDArray[np.float64], column: Column) -> float:
    """Worth of the last written decimal, where stamps repeat because samples follow each other faster than that."""
    if column.decimals is None or time_s.size < _ENOUGH:
        return 0.0
    last_s = 10.0**-column.decimals * (column.time_unit_s or 1.0)
    span_s = float(time_s[-1] - time_s[0])
    return last_s if 0 < span_s < (1 - _REPEATING) * last_s * (time_s.size - 1) else 0.0
