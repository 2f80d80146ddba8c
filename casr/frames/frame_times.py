"""When each frame was taken, from the rows of a force log; a wrong clock or unit is found here."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from casr.errors import FramesError

_Array = NDArray[np.float64]
LATEST_S = 1.0
"A frame's index is written at most so long after the frame was taken."


def times_of_frames(
    index: NDArray[np.int64], n_frames: int, time_s: _Array, frame_time_s: _Array, where: object
) -> _Array:
    """(n_frames,) time of each frame, s; NaN where no row tells it.

    Parameters
    ----------
    index, time_s, frame_time_s : (rows,) in the order of time: last frame saved, the row's time, that frame's time.
    where : named in errors.

    Raises
    ------
    FramesError : two frames of one time, or rows that carry a frame long before or after it was taken.
    """
    frame_s, row_s = (_first(index, n_frames, values) for values in (frame_time_s, time_s))
    times = frame_s[np.isfinite(frame_s)]
    if (np.diff(times) <= 0).any():
        at = int(np.argmax(np.diff(times) <= 0))
        raise FramesError(
            where,
            wanted="another frame_time_s for each frame",
            found=f"{times[at + 1]:.12g} s of two frames",
            do="Write the time in seconds with all its digits, or leave frame_time_s out.",
        )
    late_s = (row_s - frame_s)[np.isfinite(row_s - frame_s)]
    period_s = float(np.median(np.diff(times))) if times.size > 1 else LATEST_S
    if late_s.size and not -period_s <= np.median(late_s) <= LATEST_S:
        raise FramesError(
            where,
            wanted="frame_time_s in seconds, on the clock of time_s",
            found=f"rows written {np.median(late_s):.4g} s after the frame they carry, in the median",
            do="Write both times by one clock and in one unit, or leave frame_time_s out.",
        )
    return frame_s


def _first(index: NDArray[np.int64], n_frames: int, values: _Array) -> _Array:
    """(n_frames,) first known value of the rows of each frame."""
    rows = np.flatnonzero((index >= 0) & np.isfinite(values))
    frames, place = np.unique(index[rows], return_index=True)
    found = np.full(n_frames, np.nan)
    found[frames] = values[rows[place]]
    return found
