"""The .mat export of Delsys' file utility: ``Channels``, ``Fs``, ``Time`` and ``Data``, one row per channel.

All rows are as long as the fastest channel needs; slower ones are filled up with zeros, and their Time runs on. The
last sample that is not zero in any row says how long the recording is, and every row is cut there. No unit is stated:
EMG is in V, as EMGworks writes it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import RecordingError
from emg2vsa.readers.on_demand import OnDemand, Track, refuse_nothing
from emg2vsa.readers.opened import Contents, unique_names

_VARIABLES = {"Channels", "Fs", "Time", "Data"}
_RATE_TOLERANCE = 1e-3
_V_NOTE = "Delsys writes EMG in V; this export does not state it."


def is_export(variables: Mapping[str, Any]) -> bool:
    """Whether the variables of a .mat file are those of the export."""
    return {name for name in variables if not name.startswith("__")} == _VARIABLES


def opened(path: Path, variables: Mapping[str, Any]) -> OnDemand:
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
