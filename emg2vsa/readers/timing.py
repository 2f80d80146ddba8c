"""The clock in a column of time stamps: rate, start, and proof that the samples are evenly spaced."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import RecordingError

_GAP = 1.5  # in sample intervals


def even_clock(
    time_s: NDArray[np.float64], where: str, place: Callable[[int], str], resolution_s: float = 0.0
) -> tuple[float, float]:
    """Rate (Hz) and start (s) of evenly spaced time stamps.

    time_s : (n,) seconds. where : file and column, for messages. place : row index to a place in the file ("line 7").
    resolution_s : rounding of the written stamps; equal neighbours within it are no fault.

    The rate is (n - 1) intervals over the whole span, which the checks below make as safe as the median step and which
    does not inherit the rounding of single stamps; it is given to nine digits. Every stamp must lie within half an
    interval of the even grid, no stamp may repeat or run backwards, and no step may exceed 1.5 intervals.

    Raises RecordingError naming the first stamp at fault.
    """
    if time_s.size < 2:
        raise RecordingError(
            where,
            wanted="at least two time stamps",
            found=str(time_s.size),
            do="Check that the recording was exported whole.",
        )
    missing = np.flatnonzero(~np.isfinite(time_s))
    if missing.size:
        raise RecordingError(
            f"{where}, {place(int(missing[0]))}",
            wanted="a time stamp",
            found="none",
            do="Add the time stamp, or remove the row.",
        )
    step = np.diff(time_s)
    interval = float(np.median(step))
    _refuse_disorder(time_s, step, interval, where, place, resolution_s)
    _refuse_gaps(time_s, step, interval, where, place, resolution_s)
    fs_hz = (time_s.size - 1) / float(time_s[-1] - time_s[0])
    grid = time_s[0] + np.arange(time_s.size) / fs_hz
    worst = int(np.argmax(np.abs(time_s - grid)))
    if abs(time_s[worst] - grid[worst]) > 0.5 / fs_hz + resolution_s:
        raise RecordingError(
            f"{where}, {place(worst)}", wanted=f"evenly spaced time (every {1 / fs_hz:.6g} s)",
            found=f"a stamp {time_s[worst] - grid[worst]:+.4g} s off that grid",
            do="Resample the recording evenly first.",
        )  # fmt: skip
    return float(f"{fs_hz:.9g}"), float(time_s[0])


def _refuse_disorder(
    time_s: NDArray[np.float64], step: NDArray[np.float64], interval: float, where: str, place: Callable[[int], str],
    resolution_s: float,
) -> None:  # fmt: skip
    wrong = np.flatnonzero(step < 0) if 2 * resolution_s > interval else np.flatnonzero(step <= 0)
    if wrong.size:
        row = int(wrong[0]) + 1
        kind = "the same stamp again" if step[row - 1] == 0 else f"a step back from {time_s[row - 1]:.9g} s"
        raise RecordingError(
            f"{where}, {place(row)}", wanted="time that rises from row to row",
            found=f"{kind} ({time_s[row]:.9g} s; {wrong.size} such rows)",
            do="Export the time with more digits, or state fs_hz and remove the time column; delete a row only where "
            "the whole row is there twice.",
        )  # fmt: skip


def _refuse_gaps(
    time_s: NDArray[np.float64], step: NDArray[np.float64], interval: float, where: str, place: Callable[[int], str],
    resolution_s: float,
) -> None:  # fmt: skip
    gaps = np.flatnonzero(step > _GAP * interval + 2 * resolution_s)
    if gaps.size:
        row = int(gaps[0]) + 1
        raise RecordingError(
            f"{where}, {place(row)}", wanted=f"one sample every {interval:.6g} s",
            found=f"a gap of {step[row - 1]:.6g} s after {time_s[row - 1]:.6g} s ({gaps.size} gaps)",
            do="Split the recording at the gap, or export it without lost samples.",
        )  # fmt: skip
