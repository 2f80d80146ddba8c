"""From a force log at the controller's rate to one force for each frame, at its exposure or as the paper has it.

The times of the frames come from the rows of the log; a wrong clock or unit is found here.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.errors import FramesError, SettingError

_Array = NDArray[np.float64]
LATEST_S = 1.0
"A frame's index is written at most so long after the frame was taken."


def _times_of_frames(
    index: NDArray[np.int64], n_frames: int, time_s: _Array, frame_time_s: _Array, where: object
) -> _Array:
    """(n_frames,) time of each frame, s; NaN where no row tells it.

    index, time_s, frame_time_s : (rows,) in the order of time: last frame saved, the row's time, that frame's time.
    where : named in errors.
    FramesError : two frames of one time, or rows that carry a frame long before or after it was taken.
    """
    frame_s, row_s = (first_of_frame(index, n_frames, values) for values in (frame_time_s, time_s))
    times = frame_s[np.isfinite(frame_s)]
    if (np.diff(times) <= 0).any():
        at = int(np.argmax(np.diff(times) <= 0))
        raise FramesError(
            where, wanted="another frame_time_s for each frame", found=f"{times[at + 1]:.12g} s of two frames",
            do="Write the time in seconds with all its digits, or leave frame_time_s out.",
        )  # fmt: skip
    late_s = (row_s - frame_s)[np.isfinite(row_s - frame_s)]
    period_s = float(np.median(np.diff(times))) if times.size > 1 else LATEST_S
    if late_s.size and not -period_s <= np.median(late_s) <= LATEST_S:
        raise FramesError(
            where, wanted="frame_time_s in seconds, on the clock of time_s",
            found=f"rows written {np.median(late_s):.4g} s after the frame they carry, in the median",
            do="Write both times by one clock and in one unit, or leave frame_time_s out.",
        )  # fmt: skip
    return frame_s


def first_of_frame(index: NDArray[np.int64], n_frames: int, values: _Array) -> _Array:
    """(n_frames,) first known value of the rows of each frame."""
    rows = np.flatnonzero((index >= 0) & np.isfinite(values))
    frames, place = np.unique(index[rows], return_index=True)
    found = np.full(n_frames, np.nan)
    found[frames] = values[rows[place]]
    return found


FORCE_RULES = ("exposure", "mean")


def force_per_frame(
    force_n: ArrayLike,
    frame_index: ArrayLike,
    n_frames: int,
    *,
    time_s: ArrayLike | None = None,
    frame_time_s: ArrayLike | None = None,
    rule: str = "exposure",
    where: object = "force log",
) -> NDArray[np.float64]:
    """(n_frames,) force of each frame, N.

    Rows before the first frame (index -1) and rows without a force (NaN) do not count; a frame without rows gets NaN.

    force_n : (rows,) force, N.
    frame_index : (rows,) index from 0 of the last frame saved when the row was written, -1 before the first.
    n_frames : number of frames.
    time_s, frame_time_s : (rows,) when the force was read, and when the frame with the row's index was taken, s on one
        clock; NaN where that is not known.
    rule : ``mean``: of the rows that carry the frame's index, as the paper resamples 200 Hz to 20 Hz (section VI-B).
        These rows were written after the frame, so a rising force comes out as it was half a frame later: at 5 mm/s
        into a stiff specimen 0.4 N too large. ``exposure``: where the frame was taken. With both times, see
        `force_at_exposure`; without, between the means of the frame before and of the frame, which is exact for a
        force that rises evenly and frames that come halfway between rows, and a first frame keeps its mean.
    where : named in errors.
    FramesError : arrays of different length, an index that is not an integer from -1 on, or beyond the last frame.
    SettingError : an unknown rule.
    """
    if rule not in FORCE_RULES:
        raise SettingError("rule", wanted=" or ".join(FORCE_RULES), found=repr(rule), do="Choose one of these.")
    force = np.asarray(force_n, dtype=np.float64).ravel()
    index = _integers(frame_index, where)
    if force.shape != index.shape:
        raise FramesError(
            where, wanted="a frame index for each force", found=f"{len(force)} forces and {len(index)} frame indices",
            do="Correct the force log.",
        )  # fmt: skip
    if index.size and (index.min() < -1 or index.max() >= n_frames):
        bad = int(index.min() if index.min() < -1 else index.max())
        raise FramesError(
            where, wanted=f"frame indices from -1 to {n_frames - 1}, for there are {n_frames} frames",
            found=f"index {bad}",
            do="Give the frames this log belongs to; frames are counted from 0, and -1 is before the first.",
        )  # fmt: skip
    if rule == "exposure" and time_s is not None and frame_time_s is not None:
        row_s, taken_s = np.asarray(time_s, dtype=np.float64), np.asarray(frame_time_s, dtype=np.float64)
        frame_s, read = _times_of_frames(index, n_frames, row_s, taken_s, where), np.isfinite(force + row_s)
        if np.isfinite(frame_s).any() and read.any():
            return force_at_exposure(frame_s, row_s[read], force[read])
    counted = (index >= 0) & np.isfinite(force)
    rows = np.bincount(index[counted], minlength=n_frames)
    total = np.bincount(index[counted], weights=force[counted], minlength=n_frames)
    with np.errstate(invalid="ignore"):
        mean: NDArray[np.float64] = total / rows
    return mean if rule == "mean" else _between(mean, rows)


def _between(mean: NDArray[np.float64], rows: NDArray[np.int64]) -> NDArray[np.float64]:
    """Force where the rows of one frame end and those of the next begin; rows are as good as time."""
    before, after = rows[:-1], rows[1:]
    here = mean.copy()
    both = (before > 0) & (after > 0)
    with np.errstate(invalid="ignore"):
        between = (after * mean[:-1] + before * mean[1:]) / (before + after)
    here[1:][both] = between[both]
    return here


def _integers(frame_index: ArrayLike, where: object) -> NDArray[np.int64]:
    index = np.asarray(frame_index).ravel()
    whole = np.isfinite(index) & (index == np.floor(index))
    if not whole.all():
        row = int(np.argmin(whole))
        raise FramesError(
            where, wanted="whole frame indices", found=f"{index[row]} in row {row}", do="Correct the force log."
        )
    return index.astype(np.int64)


WINDOW = 0.25
"Part of a frame's period, before and after the frame, whose readings tell its force."
FEWEST = 3
"With fewer readings in the window the neighbours of the frame do."
MOST_VARIANCE = 2.0
"Nor if the line's variance at the frame were more than so many times a reading's; at the end of a log it is 1 to 2."


def force_at_exposure(frame_time_s: _Array, time_s: _Array, force_n: _Array) -> _Array:
    """(T,) force, N, when each frame was taken: of the straight line through the readings around it.

    A quarter of a period is short against the loading and long against the noise of one reading: at 20 frames and
    200 readings a second five readings share it. Where there are fewer than three, or so close together that the line
    would be far less sure at the frame than one of them is, the force lies between the reading before and that after.
    Up to half a period before the first reading or after the last it is theirs. NaN farther outside, where no reading
    is within a period, and where a frame's time is NaN.

    frame_time_s : (T,) rising, s. time_s, force_n : (n,) readings in the order of time, s and N, all finite.
    Why the exposure: decision 17.
    """
    known = np.flatnonzero(np.isfinite(frame_time_s))
    found = np.full(frame_time_s.shape, np.nan)
    if known.size and time_s.size:
        found[known] = _at(frame_time_s[known], time_s, force_n)
    return found


def _at(frame_s: _Array, time_s: _Array, force_n: _Array) -> _Array:
    period_s = float(np.median(np.diff(frame_s))) if frame_s.size > 1 else 0.0
    frame = np.searchsorted((frame_s[1:] + frame_s[:-1]) / 2, time_s)  # the nearest
    apart_s = time_s - frame_s[frame]
    near = np.abs(apart_s) <= WINDOW * period_s
    line = _line_at_0(frame[near], apart_s[near], force_n[near], frame_s.size)
    between = np.where(_reached(frame_s, time_s, period_s), np.interp(frame_s, time_s, force_n), np.nan)
    return np.where(np.isfinite(line), line, between)


def _reached(frame_s: _Array, time_s: _Array, period_s: float) -> NDArray[np.bool_]:
    """Which frames have a reading so near that it speaks for them."""
    place = np.searchsorted(time_s, frame_s)
    before_s = np.abs(frame_s - time_s[np.maximum(place - 1, 0)])
    after_s = np.abs(time_s[np.minimum(place, time_s.size - 1)] - frame_s)
    outside = (frame_s < time_s[0]) | (frame_s > time_s[-1])
    # of a single frame nobody knows the period
    reach_s = np.where(outside, 0.5 * period_s, period_s or np.inf)
    return np.asarray(np.minimum(before_s, after_s) <= reach_s)


def _line_at_0(group: NDArray[np.intp], x: _Array, y: _Array, n_groups: int) -> _Array:
    """(n_groups,) value at x = 0 of the line of least squares through each group; NaN where they do not tell it."""
    n, sx, sy, sxx, sxy = (
        np.bincount(group, weights=values, minlength=n_groups) for values in (np.ones_like(x), x, y, x * x, x * y)
    )
    spread = n * sxx - sx * sx
    # the variance of the line at 0 is that of a reading times sxx / spread
    told = (n >= FEWEST) & (spread > 0) & (sxx <= MOST_VARIANCE * spread)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(told, (sxx * sy - sx * sxy) / spread, np.nan)
