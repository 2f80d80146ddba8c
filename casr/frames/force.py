"""From a force log at the controller's rate to one force for each frame, at its exposure or as the paper has it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.errors import FramesError, SettingError
from casr.frames.exposure import force_at_exposure
from casr.frames.frame_times import times_of_frames

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

    Parameters
    ----------
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

    Raises
    ------
    FramesError : arrays of different length, an index that is not an integer from -1 on, or beyond the last frame.
    SettingError : an unknown rule.
    """
    if rule not in FORCE_RULES:
        raise SettingError("rule", wanted=" or ".join(FORCE_RULES), found=repr(rule), do="Choose one of these.")
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
    if rule == "exposure" and time_s is not None and frame_time_s is not None:
        row_s, taken_s = np.asarray(time_s, dtype=np.float64), np.asarray(frame_time_s, dtype=np.float64)
        frame_s, read = times_of_frames(index, n_frames, row_s, taken_s, where), np.isfinite(force + row_s)
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
            where,
            wanted="whole frame indices",
            found=f"{index[row]} in row {row}",
            do="Correct the force log.",
        )
    return index.astype(np.int64)
