"""MATLAB .mat files: up to version 7 through scipy, 7.3 (HDF5) through the optional package pymatreader.

Every numeric vector is a channel named after its variable; the rows or columns of a matrix, whichever are fewer, are
channels "variable[1]", "variable[2]", ...; fields and cells are reached by "struct.field", "cell{2}". A text cell array
with as many entries as a matrix has channels names them and states their units, as OTBiolab's ``Description`` does
("acquired data[ %(MVC)]"); "variable[75]" still works. The rate comes from a variable called SamplingFrequency, fs or
alike, or from a time vector.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io
from numpy.typing import NDArray

from emg2vsa.errors import RecordingError
from emg2vsa.readers import delsys_mat
from emg2vsa.readers.on_demand import OnDemand
from emg2vsa.readers.opened import Contents, StoredChannel, said_by, unique_names
from emg2vsa.readers.timing import even_clock
from emg2vsa.readers.units import split_unit
from emg2vsa.recordings import ChannelInfo

_RATE_NAMES = {"samplingfrequency", "samplingrate", "samplerate", "srate", "fs", "fshz", "fsamp", "sfreq"}
_TIME_NAMES = {"time", "t", "times", "timestamp", "timestamps", "timevector"}


@dataclass(frozen=True)
class MatlabRecording:
    """series : per channel a (n,) view into the file's arrays."""

    path: Path
    contents: Contents
    series: tuple[NDArray[Any], ...]
    units: tuple[str | None, ...]
    clocks: Mapping[int, tuple[float, float]]
    "Number of samples to (rate in Hz, start in s)."

    def describe(self) -> tuple[ChannelInfo, ...]:
        return tuple(
            ChannelInfo(name, unit, self._clock(series.size)[0], series.size)
            for name, unit, series in zip(self.contents.names, self.units, self.series, strict=True)
        )

    def load(self, indices: Sequence[int]) -> list[StoredChannel]:
        channels = []
        for i in indices:
            fs_hz, start_s = self._clock(self.series[i].size)
            samples = np.array(self.series[i], dtype=np.float64)
            channels.append(StoredChannel(self.contents.names[i], samples, self.units[i], fs_hz, start_s))
        return channels

    def _clock(self, n: int) -> tuple[float, float]:
        return self.clocks.get(n) or self.clocks.get(0) or (float("nan"), 0.0)


def open_recording(path: Path) -> MatlabRecording | OnDemand:
    """Raises RecordingError for a damaged file, one without numeric vectors, or rate and time that disagree."""
    variables = _variables(path)
    if delsys_mat.is_export(variables):
        return delsys_mat.opened(path, variables)
    leaves = _flatten(variables)
    clocks = _clocks(path, leaves)
    names: list[str] = []
    units: list[str | None] = []
    series: list[NDArray[Any]] = []
    aliases: dict[str, int] = {}
    for variable, array in leaves.arrays.items():
        if _key(variable) in _TIME_NAMES or array.size < 2:
            continue
        rows = (
            array.reshape(1, -1)
            if 1 in array.shape or array.ndim == 1
            else array
            if array.shape[0] < array.shape[1]
            else array.T
        )
        labels = next((text for text in leaves.texts.values() if len(text) == len(rows) > 1), None)
        for i, row in enumerate(rows):
            own = variable if len(rows) == 1 else f"{variable}[{i + 1}]"
            name, unit = split_unit(labels[i]) if labels else (own, None)
            if labels:
                aliases[own] = len(series)
            names.append(name)
            units.append(unit)
            series.append(row)
    if not series:
        raise RecordingError(
            path, wanted="numeric vectors", found="none", do="Save the signals as vectors or matrices."
        )
    return MatlabRecording(path, Contents(unique_names(names), aliases), tuple(series), tuple(units), clocks)


def _variables(path: Path) -> dict[str, Any]:
    with path.open("rb") as file:
        head = file.read(128)
    try:
        if head.startswith(b"MATLAB 7.3"):
            return _variables_of_hdf5(path)
        return dict(scipy.io.loadmat(path))
    except (RecordingError, MemoryError):
        raise
    except Exception as error:  # scipy and h5py raise whatever their parsers stumble over
        raise RecordingError(
            path, wanted="a MATLAB file", found=f"a damaged one ({said_by(error)})", do="Save it again."
        ) from error


def _variables_of_hdf5(path: Path) -> dict[str, Any]:
    try:
        pymatreader = importlib.import_module("pymatreader")
    except ImportError as error:
        raise RecordingError(
            path, wanted="a MATLAB file up to version 7", found="version 7.3, which needs the package pymatreader",
            do="Install it (pip install 'emg2vsa[formats]'), or save with -v7.",
        ) from error  # fmt: skip
    return dict(_in_order(pymatreader.read_mat(str(path))))


def _in_order(variables: dict[str, Any]) -> list[tuple[str, Any]]:
    """pymatreader takes them from a set, whose order is another in every process, and channels are read by number."""
    return sorted(variables.items())


def _key(variable: str) -> str:
    return variable.rpartition(".")[2].lower().replace("_", "")


def _clocks(path: Path, leaves: _Leaves) -> dict[int, tuple[float, float]]:
    """Length of a channel to (rate, start); length 0 holds for all others."""
    rates = {
        name: float(a.reshape(-1)[0]) for name, a in leaves.arrays.items() if a.size == 1 and _key(name) in _RATE_NAMES
    }
    if len(set(rates.values())) > 1:
        raise RecordingError(
            path, wanted="one sampling rate", found=", ".join(f"{name} = {rate:g}" for name, rate in rates.items()),
            do="Save the channels of one rate in a file of their own.",
        )  # fmt: skip
    stated = next(iter(rates.values()), None)
    clocks = {0: (stated, 0.0)} if stated else {}
    for name, array in leaves.arrays.items():
        if _key(name) in _TIME_NAMES and array.size > 1 and array.size == max(array.shape):
            where = f"{path}, variable {name!r}"
            fs_hz, start_s = even_clock(array.reshape(-1).astype(np.float64), where, lambda i: f"element {i + 1}")
            if stated and abs(stated - fs_hz) > 1e-3 * stated:
                raise RecordingError(
                    where, wanted=f"the stated rate, {stated:g} Hz", found=f"{fs_hz:g} Hz", do="Correct one of the two."
                )
            clocks[array.size] = (stated or fs_hz, start_s)
    return clocks


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
