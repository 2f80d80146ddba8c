"""XDF (Lab Streaming Layer, LabRecorder) through pyxdf, an optional package.

Every stream has its own rate and its own channels, "stream: channel". pyxdf maps the time stamps of all streams to one
clock. Stamps jitter, and samples that were sent in one packet share the delay of the packet; an even grid is laid
through them. Its own smoothing breaks at gaps of a second only and lays one grid across shorter ones, so it is off:
where stamps lastingly leave the grid by 10 ms, samples were lost or the clock was reset, and the stream comes in
segments, each a channel of its own ("stream: channel, segment 2"). Times are those of that clock. Texts are markers:
a note says how many there are.
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

from casr.errors import said_by
from emg2vsa.errors import RecordingError
from emg2vsa.readers.on_demand import OnDemand, Track, refuse_nothing
from emg2vsa.readers.opened import Contents, unique_names
from emg2vsa.readers.timing import even_clock
from emg2vsa.readers.units import canonical

_RATE_TOLERANCE = 1e-3
_LASTING_STEP_S = 0.01
"""Stamps that leave the grid by this and stay off it: a gap. At slow rates half an interval, where that is longer."""
_AROUND_S = 1.0
"""What is looked at before and after a gap: single late packets are not lasting."""
_LEAST_S = 0.1
"""Shorter segments are not told apart from late packets."""
_UNUSUAL = 10.0
"""A gap steps this many times further than the stamps of its stream usually wander."""
_LOOKED_AT = 101


def open_recording(path: Path) -> OnDemand:
    """Decode the file. Raises RecordingError for a damaged file and one without streams of numbers."""
    said = _Said()
    logging.getLogger("pyxdf").addHandler(said)
    try:
        streams, _ = pyxdf.load_xdf(str(path), dejitter_timestamps=False)
        return _opened(path, streams, said.cut)
    except (RecordingError, MemoryError, ImportError):
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
    nominal_hz = _float(_first(stream["info"], "nominal_srate"))
    regular = nominal_hz > 0 and stamps.size > 2 and bool(np.isfinite(stamps).all())
    segments = _segments(stamps, nominal_hz) if regular else [(0, stamps.size - 1)]
    told: tuple[str, ...] = ()
    if len(segments) > 1:
        gaps = ", ".join(
            f"{stamps[b] - stamps[a]:.6g} s after {stamps[a]:.6g} s" for (_, a), (b, _) in pairwise(segments)
        )
        told = (f"{name}: {len(segments)} segments, with gaps of {gaps}; each segment is a channel of its own.",)
    for number, (first, last) in enumerate(segments, start=1):
        fs_hz, start_s, note = (_fitted if regular else _stamped)(name, stamps[first : last + 1], nominal_hz)
        for i, (label, unit) in enumerate(_labels(stream, values.shape[1])):
            part = f", segment {number}" if number > 1 else ""
            tracks.append(Track(f"{name}: {label}{part}", unit, fs_hz, last + 1 - first, start_s, (*told, *note)))
            series.append(values[first : last + 1, i])


def _segments(stamps: NDArray[np.float64], nominal_hz: float) -> list[tuple[int, int]]:
    """First and last sample of each stretch without a lasting step of the stamps (n,), in seconds, off an even grid."""
    apart = max(1, min(stamps.size // 2, round(_AROUND_S * nominal_hz)))
    interval_s = float(np.median(stamps[apart:] - stamps[:-apart])) / apart  # robust to gaps and to jitter
    off_s = stamps - interval_s * np.arange(stamps.size)
    grid = np.arange(0, stamps.size - 1, max(1, apart // 2))
    usual_s = float(np.median(_lasting_s(off_s, grid, 0, stamps.size - 1, apart)))
    step_s = max(_LASTING_STEP_S, 0.5 * interval_s, _UNUSUAL * usual_s)
    jumps = np.flatnonzero(np.abs(np.diff(off_s)) > 0.5 * step_s)
    least = max(2, round(_LEAST_S * nominal_hz))
    open_ones, found = [(0, stamps.size - 1)], []
    while open_ones:
        first, last = open_ones.pop()
        inside = jumps[(jumps >= first + least - 1) & (jumps < last - least + 1)]
        rise_s = _lasting_s(off_s, inside, first, last, apart)
        if inside.size and float(np.max(rise_s)) > step_s:
            beside = inside[rise_s > 0.8 * np.max(rise_s)]  # jitter makes jumps beside the gap, too; its own is larger
            at = int(beside[np.argmax(np.abs(off_s[beside + 1] - off_s[beside]))])
            open_ones += [(first, at), (at + 1, last)]
        else:
            found.append((first, last))
    return sorted(found)


def _lasting_s(
    off_s: NDArray[np.float64], jumps: NDArray[np.intp], first: int, last: int, apart: int
) -> NDArray[np.float64]:
    """(jumps,) how far the medians of ``off_s`` before and after each jump lie apart."""
    share = np.linspace(0.0, 1.0, _LOOKED_AT)
    before, after = np.maximum(jumps - apart, first), np.minimum(jumps + 1 + apart, last)
    left = np.rint(before[:, None] + (jumps - before)[:, None] * share).astype(np.intp)
    right = np.rint((jumps + 1)[:, None] + (after - jumps - 1)[:, None] * share).astype(np.intp)
    return np.asarray(np.abs(np.median(off_s[right], axis=1) - np.median(off_s[left], axis=1)))


def _fitted(name: str, stamps: NDArray[np.float64], nominal_hz: float) -> tuple[float, float, tuple[str, ...]]:
    """Rate and start of a segment by the straight line through its stamps, and what to say of it."""
    if stamps.size < 2:
        return float("nan"), float(stamps[0]), (f"{name}: one sample gives no rate.",)
    index = np.arange(stamps.size) - 0.5 * (stamps.size - 1)
    middle_s = float(stamps.mean())
    interval_s = float(index @ (stamps - middle_s) / (index @ index))
    start_s = middle_s + interval_s * float(index[0])
    if not interval_s > 0:
        return float("nan"), start_s, (f"{name}: its time stamps give no rate; they do not rise.",)
    off_s = stamps - middle_s - interval_s * index
    around = max(1, min(stamps.size, round(_AROUND_S * nominal_hz)))
    blocks = off_s[: stamps.size // around * around].reshape(-1, around)
    wander_s = float(np.max(np.abs(np.median(blocks, axis=1))))
    said = _compared(name, 1 / interval_s, nominal_hz)
    if wander_s > max(_LASTING_STEP_S, 0.5 * interval_s):
        said = (*said, f"{name}: its time stamps wander {1e3 * wander_s:.3g} ms off an even grid.")
    return 1 / interval_s, start_s, said


def _stamped(name: str, stamps: NDArray[np.float64], nominal_hz: float) -> tuple[float, float, tuple[str, ...]]:
    """The same of a stream that states no rate: each stamp counts as it is."""
    try:
        fs_hz, start_s = even_clock(stamps, name, lambda i: f"sample {i + 1}")
    except RecordingError as error:
        said = f"{name}: its time stamps give no rate; expected {error.wanted}, but found {error.found}."
        return float("nan"), float(stamps[0]), (said,)
    return fs_hz, start_s, _compared(name, fs_hz, nominal_hz)


def _compared(name: str, fs_hz: float, nominal_hz: float) -> tuple[str, ...]:
    if not nominal_hz > 0 or abs(fs_hz - nominal_hz) <= _RATE_TOLERANCE * nominal_hz:
        return ()
    return (f"{name}: {nominal_hz:g} Hz stated, {fs_hz:.6g} Hz by its time stamps; the latter counts.",)


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
