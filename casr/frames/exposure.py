"""The force at the moment a frame was taken, from readings with times on the same clock."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_Array = NDArray[np.float64]
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

    Parameters
    ----------
    frame_time_s : (T,) rising, s. time_s, force_n : (n,) readings in the order of time, s and N, all finite.
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
