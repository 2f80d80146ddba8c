"""XDF (Lab Streaming Layer, LabRecorder) through pyxdf, an optional package.

Every stream has its own rate and its own channels, "stream: channel". pyxdf maps the time stamps of all streams to one
clock and smooths them; a stream whose clock was reset, or that has a gap, comes in segments, and each is a channel
of its own ("stream: channel, segment 2"), for no even time runs through a gap. Times are those of that clock. Texts
are markers: a note says how many there are.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pyxdf
from numpy.typing import NDArray

from emg2vsa.errors import RecordingError
from emg2vsa.readers.on_demand import OnDemand, Track, refuse_nothing
from emg2vsa.readers.opened import Contents, said_by, unique_names
from emg2vsa.readers.timing import even_clock
from emg2vsa.readers.units import canonical

_RATE_TOLERANCE = 0.01


def open_recording(path: Path) -> OnDemand:
    """Decode the file. Raises RecordingError for a damaged file and one without streams of numbers."""
    said = _Said()
    logging.getLogger("pyxdf").addHandler(said)
    try:
        streams, _ = pyxdf.load_xdf(str(path))
        return _opened(path, streams, said.cut)
    except (RecordingError, MemoryError):
        raise
    except Exception as error:  # pyxdf raises whatever its parsing stumbles over
        raise RecordingError(
            path, wanted="an XDF file", found=f"a damaged one ({said_by(error)})", do="Export or copy the file again."
        ) from error
    finally:
        logging.getLogger("pyxdf").removeHandler(said)


class _Said(logging.Handler):
    """What pyxdf says of a file that ends too early; it raises nothing."""

    def __init__(self) -> None:
        super().__init__(logging.ERROR)
        self.cut = False

    def emit(self, record: logging.LogRecord) -> None:
        self.cut = True


def _opened(path: Path, streams: Sequence[Mapping[str, Any]], cut: bool) -> OnDemand:
    notes = ["The file is damaged or incomplete: it was read as far as pyxdf could."] if cut else []
    tracks: list[Track] = []
    series: list[NDArray[Any]] = []
    used = unique_names([_first(stream["info"], "name") for stream in streams])
    for stream, name in sorted(zip(streams, used, strict=True), key=lambda pair: int(pair[0]["info"]["stream_id"])):
        values = np.asarray(stream["time_series"]) if not isinstance(stream["time_series"], list) else None
        if values is None:
            notes.append(f"{name}: {len(stream['time_series'])} markers (texts), which are no channel.")
        elif values.shape[0] == 0:
            notes.append(f"{name}: the stream is empty.")
        else:
            _add(name, stream, values.reshape(values.shape[0], -1), tracks, series)
    if not tracks:
        raise RecordingError(
            path, wanted="a stream of numbers", found="; ".join(notes) or "no streams", do="Choose another file."
        )
    refuse_nothing(path, tracks)
    names = unique_names([track.name for track in tracks])

    def decode(indices: Sequence[int]) -> list[NDArray[Any]]:
        for i in indices:
            if np.isnan(tracks[i].fs_hz):
                raise RecordingError(
                    f"{path}, channel {names[i]!r}", wanted="evenly spaced time stamps",
                    found="; ".join(tracks[i].notes), do="Choose another stream, or resample this one evenly first.",
                )  # fmt: skip
        return [series[i] for i in indices]

    return OnDemand(path, Contents(names, notes=tuple(notes)), tuple(tracks), decode)


def _add(
    name: str, stream: Mapping[str, Any], values: NDArray[Any], tracks: list[Track], series: list[NDArray[Any]]
) -> None:
    stamps = np.asarray(stream["time_stamps"], np.float64)
    segments = [(a, b) for a, b in stream["info"].get("segments", []) if b > a] or [(0, stamps.size - 1)]
    nominal_hz = _float(_first(stream["info"], "nominal_srate"))
    told: tuple[str, ...] = ()
    if len(segments) > 1:
        gaps = ", ".join(
            f"{stamps[b] - stamps[a]:.6g} s after {stamps[a]:.6g} s" for (_, a), (b, _) in pairwise(segments)
        )
        told = (f"{name}: {len(segments)} segments, with gaps of {gaps}; each segment is a channel of its own.",)
    for number, (first, last) in enumerate(segments, start=1):
        fs_hz, note = _rate(name, stamps[first : last + 1], nominal_hz)
        for i, (label, unit) in enumerate(_labels(stream, values.shape[1])):
            part = f", segment {number}" if number > 1 else ""
            tracks.append(
                Track(f"{name}: {label}{part}", unit, fs_hz, last + 1 - first, float(stamps[first]), (*told, *note))
            )
            series.append(values[first : last + 1, i])


def _rate(name: str, stamps: NDArray[np.float64], nominal_hz: float) -> tuple[float, tuple[str, ...]]:
    """Rate of a segment by its stamps, NaN where they are uneven, and what to say of it."""
    try:
        fs_hz, _ = even_clock(stamps, name, lambda i: f"sample {i + 1}")
    except RecordingError as error:
        return float("nan"), (f"{name}: its time stamps give no rate; wanted {error.wanted}, found {error.found}.",)
    if nominal_hz > 0 and abs(fs_hz - nominal_hz) > _RATE_TOLERANCE * nominal_hz:
        return fs_hz, (f"{name}: {nominal_hz:g} Hz stated, {fs_hz:.6g} Hz by its time stamps; the latter counts.",)
    return fs_hz, ()


def _labels(stream: Mapping[str, Any], n: int) -> list[tuple[str, str | None]]:
    """(label, unit) of each channel, from desc/channels/channel where the stream has it for every one."""
    try:
        stated = stream["info"]["desc"][0]["channels"][0]["channel"]
    except (KeyError, IndexError, TypeError):
        stated = []
    if len(stated) != n:
        return [(str(i + 1), None) for i in range(n)]
    return [(_first(each, "label") or str(i), _unit(_first(each, "unit"))) for i, each in enumerate(stated, start=1)]


def _unit(text: str) -> str | None:
    unit = canonical(text)
    return {"microvolts": "uV", "microvolt": "uV"}.get(unit.lower(), unit) or None


def _first(stated: Mapping[str, Any], key: str) -> str:
    values = stated.get(key)
    return str(values[0]) if isinstance(values, list) and values and values[0] is not None else ""


def _float(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return float("nan")
