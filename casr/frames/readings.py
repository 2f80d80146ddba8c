"""A force log with times: what the force was at any moment, and readings that cannot be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.errors import FramesError
from casr.frames.force import force_at_exposure
from casr.median import median

NOISES = 10.0  # a spike is so many standard deviations of a reading off
LEAST_N = 0.1
STEPS = 3.0  # and so many times the steps of the readings beside it
RETURNS = 0.5  # of its height: beyond it the force is again where it was before
BESIDE = 3  # readings on either side
WIDEST = 2
LEAST_ROWS, REACHED = 5, 0.98
"Fewest rows that tell a slope of travel, and share of the largest force at which the indenter has gone in."
RANGE_N, EXPONENT = (0.5, 7.0), 0.57
"""Forces that travel per newton is told for, whichever a press reached, and the power of force as which travel grows:
.50 to .62 on the domes that come with casr, .5 to 4.5 N."""

_Array = NDArray[np.float64]


def spikes(force_n: ArrayLike) -> NDArray[np.bool_]:
    """(n,) which readings are spikes, in the order of time; NaN is none.

    A rise, a fall or a peak of the force is none however steep: from one of its sides a straight line leads to it, or
    the force beyond it is another. Readings next to the ends of the log are not judged.
    """
    force = np.asarray(force_n, dtype=np.float64).ravel()
    known = np.flatnonzero(np.isfinite(force))
    found = np.zeros(force.size, dtype=np.bool_)
    y = force[known]
    if y.size < 2 * BESIDE + 1:
        return found
    least_n = max(NOISES * noise_n(y), LEAST_N)
    for width in range(1, WIDEST + 1):
        found[known[_of_width(y, width, least_n)]] = True
    return found


def noise_n(y: _Array) -> float:
    """Standard deviation of one of (n,) readings, N, by second differences, to which a steady rise adds nothing."""
    return float(1.4826 * median(np.abs(np.diff(y, 2))) / np.sqrt(6))


def _of_width(y: _Array, width: int, least_n: float) -> NDArray[np.intp]:
    """Rows in spikes of so many readings."""
    first = np.arange(BESIDE, y.size - BESIDE - width + 1)
    before = y[first[:, None] - np.arange(BESIDE, 0, -1)]
    after = y[first[:, None] + width + np.arange(BESIDE)]
    inside = y[first[:, None] + np.arange(width)]
    level_n = median(np.hstack([before, after]), axis=1)
    off_n = inside - level_n[:, None]
    height_n = np.abs(off_n).min(axis=1)
    one_side = (off_n > 0).all(axis=1) | (off_n < 0).all(axis=1)
    steps_n = np.maximum(np.abs(np.diff(before)).max(axis=1), np.abs(np.diff(after)).max(axis=1))
    # the straight lines on from the two readings on either side
    reach = np.arange(1, width + 1)
    forward = before[:, -1:] + (before[:, -1:] - before[:, -2:-1]) * reach
    back = after[:, :1] + (after[:, :1] - after[:, 1:2]) * reach[::-1]
    missed_n = np.minimum(np.abs(inside - forward), np.abs(inside - back)).min(axis=1)
    returns = np.abs(after[:, 0] - before[:, -1]) <= RETURNS * height_n
    spike = one_side & returns & (np.minimum(height_n, missed_n) > np.maximum(least_n, STEPS * steps_n))
    return np.unique(first[spike][:, None] + np.arange(width))


def note_on_spikes(found: NDArray[np.bool_], force_n: _Array, what: str) -> tuple[str, ...]:
    """What was left out of ``what``, such as rows of the force log. found : (n,), of forces (n,), N."""
    if not found.any():
        return ()
    farthest_n = float(force_n[found][np.argmax(np.abs(force_n[found]))])
    count = int(found.sum())
    return (f"{count} {what} {'is a spike' if count == 1 else 'are spikes'} (up to {farthest_n:.3g} N) and left out",)


MOST_N = 200.0
"A tactile sensor of the hand's size stands no more."


@dataclass(frozen=True, eq=False)
class ForceReadings:
    """Readings of the force sensor and when the frames were taken, by one clock.

    time_s, force_n : (n,) in the order of time, all finite. frame_time_s : (T,) rising; NaN where not known.
    """

    time_s: _Array
    force_n: _Array
    frame_time_s: _Array

    def at_frames(self, lag_s: float = 0.0) -> _Array:
        """(T,) force of each frame, N, if frames were taken ``lag_s`` before their times; NaN where not known."""
        return force_at_exposure(self.frame_time_s - lag_s, self.time_s, self.force_n)


@dataclass(frozen=True, eq=False)
class TravelReadings:
    """How far the indenter has gone at readings of the force, as the log has them.

    travel_mm, force_n : (n,) NaN where not known. frame_index : (n,) of the last frame saved.
    """

    travel_mm: _Array
    force_n: _Array
    frame_index: NDArray[np.int64]

    def per_newton(self, rest: int, from_n: float, to_n: float, zero_n: float) -> float:
        """Mean travel for each newton, mm/N, as it would be over ``RANGE_N``; NaN as of ``travel_per_newton``.

        rest : the rest frame. from_n, to_n : forces of the loading, N; zero_n : what the sensor reads at rest.
        """
        known = np.isfinite(self.force_n + self.travel_mm) & (self.frame_index >= rest)
        force_n, travel_mm = self.force_n[known] - zero_n, self.travel_mm[known]
        if not force_n.size or (top_n := min(REACHED * float(force_n.max()), to_n)) <= from_n:
            return float("nan")
        last = int(np.argmax(force_n >= top_n)) + 1
        over = _slope_of_power(*RANGE_N) / _slope_of_power(from_n, top_n)
        return travel_per_newton(force_n[:last], travel_mm[:last], from_n) * over


def _slope_of_power(low: float, high: float) -> float:
    """Slope of the line of least squares through force^``EXPONENT`` between two forces."""
    force = np.linspace(low, high, 101)
    return float((force - force.mean()) @ force**EXPONENT / np.sum((force - force.mean()) ** 2))


def travel_per_newton(force_n: _Array, travel_mm: _Array, from_n: float) -> float:
    """Mean travel for each newton, mm/N, of readings (K,) while the indenter goes in, from ``from_n`` on.

    Travel is regressed on force: the error is in the steps of an encoder, and what enters is the mean compliance of
    sensor and specimen in series over the same forces for every press. NaN where there are fewer than
    ``LEAST_ROWS`` readings, or where the indenter does not go in.
    """
    known = np.isfinite(force_n) & np.isfinite(travel_mm)
    force, travel = force_n[known], travel_mm[known]
    first = int(np.argmax(force >= from_n)) if np.any(force >= from_n) else force.size
    force, travel = force[first:], travel[first:]
    if force.size < LEAST_ROWS or np.ptp(force) == 0:
        return float("nan")
    centred = force - force.mean()
    mm_per_n = float(centred @ travel / (centred @ centred))
    return mm_per_n if mm_per_n > 0 else float("nan")


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
            where, wanted=f"forces in N, {MOST_N:g} at most", found=f"{largest_n:.6g}",
            do="Which unit is it? Name the column so, such as force_mn for mN, or give the log in N.",
        )  # fmt: skip
