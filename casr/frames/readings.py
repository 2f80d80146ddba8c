"""A force log with times: what the force was at any moment, also where the camera's clock is off."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from casr.errors import FramesError
from casr.frames.force import force_at_exposure

_Array = NDArray[np.float64]
MOST_N = 200.0
"A tactile sensor of the hand's size stands no more."


@dataclass(frozen=True, eq=False)
class ForceReadings:
    """Readings of the force sensor and when the frames were taken, by one clock.

    Parameters
    ----------
    time_s, force_n : (n,) in the order of time, all finite. frame_time_s : (T,) rising; NaN where not known.
    """

    time_s: _Array
    force_n: _Array
    frame_time_s: _Array

    def at_frames(self, lag_s: float = 0.0) -> _Array:
        """(T,) force of each frame, N, if frames were taken ``lag_s`` before their times; NaN where not known."""
        return force_at_exposure(self.frame_time_s - lag_s, self.time_s, self.force_n)


def frame_times_by_rows(time_s: _Array, frame_index: NDArray[np.int64], n_frames: int) -> _Array:
    """(n_frames,) time of each frame, s: halfway between the last row before it and its first; NaN without a row."""
    first = np.flatnonzero(np.diff(frame_index) > 0) + 1
    found = np.full(n_frames, np.nan)
    found[frame_index[first]] = (time_s[first] + time_s[first - 1]) / 2
    return found


def check_newtons(force_n: _Array, where: object) -> None:
    """Raises FramesError for forces (T,) too large to be newtons."""
    largest_n = float(np.nanmax(np.abs(force_n), initial=0.0))
    if largest_n > MOST_N:
        raise FramesError(
            where,
            wanted=f"forces in N, {MOST_N:g} at most",
            found=f"{largest_n:.6g}",
            do="Which unit is it? Name the column so, such as force_mn for mN, or give the log in N.",
        )
