"""Scores of repeated presses: scatter, outliers, and presses drawn again; NaN where there is no press."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, Ints, mean_of

_LEAST_TO_JUDGE = 5
MOST_OUTLIERS = 0.2
"""Share of a specimen's presses that may be outliers. Where more lie far off, the presses simply scatter."""
_SD_PER_MAD = 1.4826


def within(scores: Floats) -> tuple[Floats, Ints]:
    """Variance of a single press (d, S) from presses (d, S, R), NaN where it was not repeated, and presses (d, S)."""
    there = np.isfinite(scores)
    n = np.count_nonzero(there, axis=-1)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        squares = np.sum(np.where(there, scores - mean_of(scores)[..., None], 0.0) ** 2, axis=-1)
        return np.where(n > 1, squares / (n - 1), np.nan), n


def redrawn(scores: Floats, resamples: int, rng: np.random.Generator) -> Floats:
    """One press fewer than there are, drawn with replacement from each group: (d, B, ..., R) from scores (d, ..., R).

    Means of one fewer have the variance s^2 / n of the mean that is judged; means of as many have (n - 1) / n of it,
    and intervals from ten presses would cover 1.5 % less (Hesterberg 2015). A single press is drawn as it is. The draws
    are the same for all d, so that the answer for one does not depend on its company.
    """
    first = np.sort(scores, axis=-1)[:, None]  # NaN last
    count = np.count_nonzero(np.isfinite(first), axis=-1, keepdims=True)
    index = (rng.random((resamples, *scores.shape[1:])) * count).astype(np.int64)
    return np.where(
        np.arange(scores.shape[-1]) < np.maximum(count - 1, 1), np.take_along_axis(first, index, axis=-1), np.nan
    )


def without_outliers(scores: Floats, mads: float) -> Floats:
    """Presses (S, R) with the outliers of each specimen (``far_off``) set to NaN.

    A specimen with more outliers than ``MOST_OUTLIERS`` of its presses keeps all of them. Outliers by Hampel (1974).
    """
    far = far_off(scores, mads)
    few = np.count_nonzero(far, axis=-1) <= MOST_OUTLIERS * np.count_nonzero(np.isfinite(scores), axis=-1)
    return np.where(far & few[:, None], np.nan, scores)


def far_off(scores: Floats, mads: float) -> NDArray[np.bool_]:
    """Presses (S, R) more than ``mads`` scaled median absolute deviations (Hampel 1974) from their specimen's median.

    None where ``mads`` is 0. Fewer than five presses cannot tell which of them is wrong.
    """
    judged = np.count_nonzero(np.isfinite(scores), axis=-1, keepdims=True) >= _LEAST_TO_JUDGE
    away = np.abs(scores - _median(scores))
    limit = mads * _SD_PER_MAD * _median(away)
    with np.errstate(invalid="ignore"):
        return np.asarray(judged & (limit > 0) & (away > limit))


def _median(scores: Floats) -> Floats:
    """(S, 1) median of the presses that are there; NaN where there is none."""
    ordered = np.sort(scores, axis=-1)  # NaN last
    n = np.count_nonzero(np.isfinite(scores), axis=-1, keepdims=True)
    middle = [np.take_along_axis(ordered, np.clip(at, 0, None), axis=-1) for at in ((n - 1) // 2, n // 2)]
    return np.asarray(np.where(n > 0, (middle[0] + middle[1]) / 2, np.nan))
