"""MATLAB .mat files: up to version 7 through scipy, 7.3 (HDF5) through the optional package pymatreader.

Every numeric vector is a channel named after its variable; the rows or columns of a matrix, whichever are fewer, are
channels "variable[1]", "variable[2]", ...; fields and cells are reached by "struct.field", "cell{2}". A text cell array
called Description, labels, names or alike with as many entries as a matrix has channels names them and states their
units, as OTBiolab's ``Description`` does ("acquired data[ %(MVC)]"), and so does one of any name that is the only one
of this length, if one matrix only has so many; "variable[75]" still works. The rate comes from a variable called
SamplingFrequency, fs or alike, or from a time vector; ``fs_EMG`` and ``t_EMG`` hold for ``EMG`` alone.

A file with ``Channels``, ``Fs``, ``Time`` and ``Data`` is an export of Delsys' file utility, one row per channel. All
rows are as long as the fastest channel needs; slower ones are filled up with zeros, and their Time runs on. The
last sample that is not zero in any row says how long the recording is, and every row is cut there. No unit is stated:
EMG is in V, as EMGworks writes it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io
from numpy.typing import NDArray

from casr.by_name import module_named
from casr.errors import install_extra, said_by
from emg2vsa.errors import PassingError, RecordingError
from emg2vsa.readers.on_demand import OnDemand, Track, refuse_nothing
from emg2vsa.readers.opened import Contents, StoredChannel, unique_names
from emg2vsa.readers.timing import even_clock
from emg2vsa.readers.units import split_unit
from emg2vsa.recordings import ChannelInfo

_VARIABLES = {"Channels", "Fs", "Time", "Data"}
_RATE_TOLERANCE = 1e-3
_V_NOTE = "Delsys writes EMG in V; this export does not state it."


def is_delsys_export(variables: Mapping[str, Any]) -> bool:
    """Whether the variables of a .mat file are those of the export."""
    return {name for name in variables if not name.startswith("__")} == _VARIABLES


def delsys_opened(path: Path, variables: Mapping[str, Any]) -> OnDemand:
    """Raises RecordingError where the four variables do not fit together."""
    names = [str(np.asarray(name).reshape(-1)[0] if np.size(name) else "") for name in np.ravel(variables["Channels"])]
    data, time_s = (_matrix(path, key, variables[key]) for key in ("Data", "Time"))
    fs_hz = _matrix(path, "Fs", variables["Fs"]).reshape(-1)
    if not len(names) == len(fs_hz) == len(data) == len(time_s) or data.shape != time_s.shape:
        found = f"{len(names)} Channels, {len(fs_hz)} Fs, Time {time_s.shape}, Data {data.shape}"
        raise RecordingError(path, wanted="one row per channel", found=found, do="Export the recording again.")
    for name, rate_hz, stamps in zip(names, fs_hz, time_s, strict=True):
        step_hz = 1 / (stamps[1] - stamps[0]) if stamps.size > 1 and stamps[1] > stamps[0] else float("nan")
        if not (0 < rate_hz < 1e9 and abs(step_hz - rate_hz) <= _RATE_TOLERANCE * rate_hz):
            raise RecordingError(
                f"{path}, channel {name.strip()!r}", wanted="a rate in Fs that agrees with the steps of Time",
                found=f"{rate_hz:g} Hz in Fs, {step_hz:g} Hz by Time", do="Export the recording again.",
            )  # fmt: skip
    last = [int(filled[-1]) + 1 if (filled := np.flatnonzero(row)).size else 0 for row in data]
    duration_s = max((n / rate for n, rate in zip(last, fs_hz, strict=True)), default=0.0)
    tracks = tuple(
        _track(name.strip(), float(rate), min(data.shape[1], round(duration_s * rate)), float(stamps[0]))
        for name, rate, stamps in zip(names, fs_hz, time_s, strict=True)
    )
    refuse_nothing(path, tracks)

    def decode(indices: Sequence[int]) -> list[NDArray[np.float64]]:
        return [data[i, : tracks[i].n_samples] for i in indices]

    cut = data.shape[1] - max(track.n_samples for track in tracks)
    notes = (f"The last {cut} samples are zero in all rows and were cut.",) if cut else ()
    return OnDemand(path, Contents(unique_names([track.name for track in tracks]), notes=notes), tracks, decode)


def _track(name: str, fs_hz: float, n: int, start_s: float) -> Track:
    if re.search(r"\bEMG\b", name):
        return Track(name, "V", fs_hz, n, start_s, (_V_NOTE,))
    return Track(name, None, fs_hz, n, start_s)


def _matrix(path: Path, key: str, value: Any) -> NDArray[np.float64]:
    array = np.asarray(value)
    if array.dtype.kind not in "iuf" or array.ndim > 2 or array.size == 0:
        raise RecordingError(
            f"{path}, variable {key!r}", wanted="a matrix of numbers", found=f"{array.dtype} of shape {array.shape}",
            do="Export the recording again.",
        )  # fmt: skip
    return np.atleast_2d(array).astype(np.float64)


_RATE_NAMES = {"samplingfrequency", "samplingrate", "samplerate", "srate", "fs", "fshz", "fsamp", "sfreq"}
_TIME_NAMES = {"time", "t", "times", "timestamp", "timestamps", "timevector"}
_TABLE = 0.05
"""Vectors shorter than this part of the longest are tables of something else, and nothing is said of their rate."""
_LABEL_NAMES = {
    "description", "descriptions", "label", "labels", "channel", "channels", "channelname", "channelnames",
    "channellabel", "channellabels", "chname", "chnames", "chlabel", "chlabels", "name", "names", "muscle", "muscles",
}  # fmt: skip


@dataclass(frozen=True)
class MatlabRecording:
    """series : per channel a (n,) view into the file's arrays."""

    path: Path
    contents: Contents
    series: tuple[NDArray[Any], ...]
    units: tuple[str | None, ...]
    clocks: tuple[tuple[float, float], ...]
    "(rate in Hz, start in s) of each."

    def describe(self) -> tuple[ChannelInfo, ...]:
        return tuple(
            ChannelInfo(name, unit, fs_hz, series.size)
            for name, unit, series, (fs_hz, _) in zip(
                self.contents.names, self.units, self.series, self.clocks, strict=True
            )
        )

    def load(self, indices: Sequence[int]) -> list[StoredChannel]:
        channels = []
        for i in indices:
            fs_hz, start_s = self.clocks[i]
            samples = np.array(self.series[i], dtype=np.float64)
            channels.append(StoredChannel(self.contents.names[i], samples, self.units[i], fs_hz, start_s))
        return channels


def open_recording(path: Path) -> MatlabRecording | OnDemand:
    """Raises RecordingError for a damaged file, one without numeric vectors, or rate and time that disagree."""
    variables = _variables(path)
    if is_delsys_export(variables):
        return delsys_opened(path, variables)
    leaves = _flatten(variables)
    rows_of = {
        variable: _rows(array)
        for variable, array in leaves.arrays.items()
        if array.size > 1 and not (_is_time(variable, leaves) or _is_rate(variable, leaves))
    }
    if not rows_of:
        raise RecordingError(
            path, wanted="numeric vectors", found="none", do="Save the signals as vectors or matrices."
        )
    clocks = _Clocks(path, leaves, max(rows.shape[1] for rows in rows_of.values()))
    names: list[str] = []
    units: list[str | None] = []
    series: list[NDArray[Any]] = []
    of_each: list[tuple[float, float]] = []
    aliases: dict[str, int] = {}
    notes: list[str] = []
    for variable, rows in rows_of.items():
        labels = _labels(variable, rows_of, leaves, notes)
        clock = clocks.of(variable, rows.shape[1])
        for i, row in enumerate(rows):
            own = variable if len(rows) == 1 else f"{variable}[{i + 1}]"
            name, unit = split_unit(labels[i]) if labels else (own, None)
            if labels:
                aliases[own] = len(series)
            names.append(name)
            units.append(unit)
            series.append(row)
            of_each.append(clock)
    contents = Contents(unique_names(names), aliases, (*notes, *clocks.notes))
    return MatlabRecording(path, contents, tuple(series), tuple(units), tuple(of_each))


def _rows(array: NDArray[Any]) -> NDArray[Any]:
    """(channels, n): a vector is one channel, the fewer of rows and columns are channels."""
    if 1 in array.shape or array.ndim == 1:
        return array.reshape(1, -1)
    return array if array.shape[0] < array.shape[1] else array.T


def _labels(variable: str, rows_of: Mapping[str, NDArray[Any]], leaves: _Leaves, notes: list[str]) -> list[str] | None:
    """The text cell that names the channels of a matrix; None, and a note, where it may belong elsewhere."""
    n = len(rows_of[variable])
    fitting = {name: texts for name, texts in leaves.texts.items() if len(texts) == n > 1}
    known = {name: texts for name, texts in fitting.items() if _key(name) in _LABEL_NAMES}
    beside = {name: texts for name, texts in known.items() if name.rpartition(".")[0] == variable.rpartition(".")[0]}
    chosen = beside or known or fitting
    others = [name for name, rows in rows_of.items() if len(rows) == n and name != variable]
    if len(chosen) == 1 and (known or not others):
        return next(iter(chosen.values()))
    if chosen:
        found = ", ".join(chosen) + (f"; {', '.join(others)} has as many" if others and not known else "")
        notes.append(f"{variable}: its channels are numbered, for it is not clear that they are named by {found}.")
    return None


def _variables(path: Path) -> dict[str, Any]:
    with path.open("rb") as file:
        head = file.read(128)
    try:
        if head.startswith(b"MATLAB 7.3"):
            return _variables_of_hdf5(path)
        return dict(scipy.io.loadmat(path))
    except (RecordingError, MemoryError, ImportError):
        raise
    except Exception as error:  # scipy and h5py raise whatever their parsers stumble over
        raise RecordingError(
            path, wanted="a MATLAB file", found=f"a damaged one ({said_by(error)})", do="Save it again."
        ) from error


def _variables_of_hdf5(path: Path) -> dict[str, Any]:
    try:
        pymatreader = module_named("pymatreader")
        module_named("h5py")  # decodes the samples; pymatreader imports it when it opens a file
    except ModuleNotFoundError as error:
        raise PassingError(
            path, wanted="a MATLAB file up to version 7",
            found="version 7.3, which needs the packages pymatreader and h5py",
            do=f"Install them ({install_extra('formats')}), or save with -v7.",
        ) from error  # fmt: skip
    return dict(_in_order(pymatreader.read_mat(str(path))))


def _in_order(variables: dict[str, Any]) -> list[tuple[str, Any]]:
    """pymatreader takes them from a set, whose order is another in every process, and channels are read by number."""
    return sorted(variables.items())


def _key(variable: str) -> str:
    return variable.rpartition(".")[2].lower().replace("_", "")


def _owner(variable: str, kinds: set[str], leaves: _Leaves) -> str | None:
    """The variable that ``fs_EMG`` or ``t_EMG`` belongs to; None where it is no such name."""
    before, dot, last = variable.rpartition(".")
    for place, sign in enumerate(last):
        if sign == "_" and _key(last[:place]) in kinds:
            own = f"{before}{dot}{last[place + 1 :]}"
            if own in leaves.arrays:
                return own
    return None


def _is_time(variable: str, leaves: _Leaves) -> bool:
    return _key(variable) in _TIME_NAMES or _owner(variable, _TIME_NAMES, leaves) is not None


def _is_rate(variable: str, leaves: _Leaves) -> bool:
    return _key(variable) in _RATE_NAMES or _owner(variable, _RATE_NAMES, leaves) is not None


class _Clocks:
    """Rate and start of the variables of a file, whose longest has ``longest`` samples."""

    def __init__(self, path: Path, leaves: _Leaves, longest: int) -> None:
        self._path, self._leaves, self._longest = path, leaves, longest
        self.notes: list[str] = []
        rates = {name: _scalar(a) for name, a in leaves.arrays.items() if a.size == 1 and _key(name) in _RATE_NAMES}
        if len(set(rates.values())) > 1:
            raise RecordingError(
                path, wanted="one sampling rate", found=", ".join(f"{name} = {rate:g}" for name, rate in rates.items()),
                do="Save the channels of one rate in a file of their own, or call their rates fs_<variable>.",
            )  # fmt: skip
        self._stated = next(iter(rates.values()), None)
        self._own_rates = {
            own: _scalar(a)
            for name, a in leaves.arrays.items()
            if a.size == 1 and (own := _owner(name, _RATE_NAMES, leaves)) is not None
        }
        self._times: dict[str, tuple[float, float]] = {}
        self._shared: dict[int, tuple[float, float]] = {}
        for name, array in leaves.arrays.items():
            if array.size > 1 and array.size == max(array.shape) and _is_time(name, leaves):
                self._add_time(name, array)

    def _add_time(self, name: str, array: NDArray[Any]) -> None:
        where = f"{self._path}, variable {name!r}"
        fs_hz, start_s = even_clock(array.reshape(-1).astype(np.float64), where, lambda i: f"element {i + 1}")
        own = None if _key(name) in _TIME_NAMES else _owner(name, _TIME_NAMES, self._leaves)
        shared = self._stated if array.size == self._longest else None
        stated = shared if own is None else self._own_rates.get(own)
        if stated and abs(stated - fs_hz) > 1e-3 * stated:
            raise RecordingError(
                where, wanted=f"the stated rate, {stated:g} Hz", found=f"{fs_hz:g} Hz", do="Correct one of the two."
            )
        if own is not None:
            self._times[own] = (stated or fs_hz, start_s)
        else:
            self._shared[array.size] = (stated or fs_hz, start_s)

    def of(self, variable: str, n: int) -> tuple[float, float]:
        """(rate, start); the rate is NaN where the file's one rate belongs to longer variables."""
        if variable in self._times:
            return self._times[variable]
        if variable in self._own_rates:
            return self._own_rates[variable], 0.0
        if n in self._shared:
            return self._shared[n]
        if self._stated is None:
            return float("nan"), 0.0
        if n != self._longest:
            if n < _TABLE * self._longest:
                return float("nan"), 0.0
            said = f"{variable}: {n} samples, while the rate of {self._stated:g} Hz is that of the {self._longest} of "
            self.notes.append(f"{said}the longest; its own is not known (save it as fs_{variable}).")
            return float("nan"), 0.0
        return self._stated, 0.0


def _scalar(array: NDArray[Any]) -> float:
    return float(array.reshape(-1)[0])


@dataclass(frozen=True)
class _Leaves:
    """arrays : dotted name to a numeric array. texts : dotted name to the entries of a text cell array."""

    arrays: dict[str, NDArray[Any]] = field(default_factory=dict)
    texts: dict[str, list[str]] = field(default_factory=dict)


def _flatten(variables: dict[str, Any]) -> _Leaves:
    """All numeric arrays of one or two dimensions and all text lists; ``__header__`` and its like are left out."""
    leaves = _Leaves()
    for name, value in variables.items():
        if not name.startswith("__"):
            _walk(name, value, leaves)
    return leaves


def _walk(name: str, value: Any, leaves: _Leaves) -> None:
    if isinstance(value, dict):
        for key, item in _in_order(value):
            _walk(f"{name}.{key}", item, leaves)
    elif isinstance(value, np.ndarray) and value.dtype.names:
        for element, where in zip(value.reshape(-1), _numbered(name, value.size), strict=True):
            for key in value.dtype.names:
                _walk(f"{where}.{key}", element[key], leaves)
    elif isinstance(value, list) or (isinstance(value, np.ndarray) and value.dtype == object):
        _walk_cell(name, list(value) if isinstance(value, list) else list(value.reshape(-1)), leaves)
    elif np.asarray(value).dtype.kind in "buif" and np.asarray(value).ndim <= 2:
        leaves.arrays[name] = np.asarray(value)


def _walk_cell(name: str, items: list[Any], leaves: _Leaves) -> None:
    texts = [_text(item) for item in items]
    if items and all(text is not None for text in texts):
        leaves.texts[name] = [str(text) for text in texts]
        return
    for item, where in zip(items, _numbered(name, len(items)), strict=True):
        _walk(where, item, leaves)


def _numbered(name: str, n: int) -> list[str]:
    return [name] if n == 1 else [f"{name}{{{i + 1}}}" for i in range(n)]


def _text(item: Any) -> str | None:
    if isinstance(item, str):
        return item
    if isinstance(item, np.ndarray) and item.dtype.kind == "U" and item.size == 1:
        return str(item.reshape(-1)[0])
    return None
