"""How far scores set specimens apart, in numbers that compare between algorithms and between actuators.

Rank tests cannot compare them: once specimens do not overlap, p and epsilon squared are at their bounds.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, Ints
from emg2vsa.discrimination.run_table import mean_of


def smallest_gap(samples: Floats) -> Floats:
    """(...) of scores (..., k specimens, n presses), stiffest first: the smallest step to the next softer, in SDs.

    A step is the difference of two neighbours' means over their pooled SD (Cohen's d); negative where the softer has
    the smaller score. NaN where a specimen has no press or there is no spread.
    """
    mean, squares, count = _moments(samples)
    with np.errstate(divide="ignore", invalid="ignore"):
        sd = np.sqrt((squares[..., 1:] + squares[..., :-1]) / (count[..., 1:] + count[..., :-1] - 2))
        gap = np.diff(mean, axis=-1) / np.where(sd > 0, sd, np.nan)
    return np.asarray(np.min(gap, axis=-1))


def repetition_cv(samples: Floats) -> Floats:
    """(...) root mean square over specimens of the presses' SD over their mean; scores as in ``smallest_gap``."""
    mean, squares, count = _moments(samples)
    with np.errstate(divide="ignore", invalid="ignore"):
        cv2 = squares / np.where(count > 1, count - 1, np.nan) / mean**2
    return np.asarray(np.sqrt(np.mean(cv2, axis=-1)))


def gap_difference(samples: Floats) -> Floats:
    """``smallest_gap`` of the first half of the groups (..., 2k, n) less that of the second."""
    first, second = np.split(samples, 2, axis=-2)
    return smallest_gap(first) - smallest_gap(second)


def level_ratio(samples: Floats) -> Floats:
    """Geometric mean over specimens of mean score, first half of the groups (..., 2k, n) over second; NaN below 0."""
    mean = mean_of(samples)
    with np.errstate(divide="ignore", invalid="ignore"):
        log = np.log(np.where(mean > 0, mean, np.nan))
    first, second = np.split(log, 2, axis=-1)
    return np.asarray(np.exp(np.mean(first - second, axis=-1)))


def pressed_everywhere(values: Floats) -> NDArray[np.int64]:
    """Places of the specimens of (D, S, R) that have two scores or more in each design that has any."""
    count = np.isfinite(values).sum(axis=2)
    return np.flatnonzero(np.all(count[count.sum(axis=1) > 0] > 1, axis=0))


def _moments(samples: Floats) -> tuple[Floats, Floats, Ints]:
    """Mean, sum of squared deviations and count along the last axis, NaN skipped."""
    there = np.isfinite(samples)
    mean = mean_of(samples)
    squares = np.sum((samples - mean[..., None]) ** 2, axis=-1, where=there)
    return mean, squares, np.count_nonzero(there, axis=-1)
