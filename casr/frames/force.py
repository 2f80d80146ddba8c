"""From a force log at the controller's rate to one force for each frame (paper, section V-B)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.errors import FramesError


def force_per_frame(
    force_n: ArrayLike, frame_index: ArrayLike, n_frames: int, *, where: object = "force log"
) -> NDArray[np.float64]:
    """(n_frames,) mean of the force rows that carry each frame's index, N.

    The paper resamples the 200 Hz force to the 20 Hz frames this way ("the mean of all the force values saved
    relative to that specific frame"). Rows before the first frame (index -1) and rows without a force (NaN) do not
    count; a frame without rows gets NaN.

    Parameters
    ----------
    force_n : (rows,) force, N.
    frame_index : (rows,) index from 0 of the last frame saved when the row was written, -1 before the first.
    n_frames : number of frames.
    where : named in errors.

    Raises
    ------
    FramesError : arrays of different length, an index that is not an integer from -1 on, or beyond the last frame.
    """
    force = np.asarray(force_n, dtype=np.float64).ravel()
    index = _integers(frame_index, where)
    if force.shape != index.shape:
        raise FramesError(
            where,
            wanted="a frame index for each force",
            found=f"{len(force)} forces and {len(index)} frame indices",
            do="Correct the force log.",
        )
    if index.size and (index.min() < -1 or index.max() >= n_frames):
        bad = int(index.min() if index.min() < -1 else index.max())
        raise FramesError(
            where,
            wanted=f"frame indices from -1 to {n_frames - 1}, for there are {n_frames} frames",
            found=f"index {bad}",
            do="Give the frames this log belongs to; frames are counted from 0, and -1 is before the first.",
        )
    counted = (index >= 0) & np.isfinite(force)
    rows = np.bincount(index[counted], minlength=n_frames)
    total = np.bincount(index[counted], weights=force[counted], minlength=n_frames)
    with np.errstate(invalid="ignore"):
        mean: NDArray[np.float64] = total / rows
    return mean


def _integers(frame_index: ArrayLike, where: object) -> NDArray[np.int64]:
    index = np.asarray(frame_index).ravel()
    whole = np.isfinite(index) & (index == np.floor(index))
    if not whole.all():
        row = int(np.argmin(whole))
        raise FramesError(
            where,
            wanted="whole frame indices",
            found=f"{index[row]} in row {row}",
            do="Correct the force log.",
        )
    return index.astype(np.int64)
