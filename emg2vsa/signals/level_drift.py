"""The trend of a muscle's level over the presses of a recording: an electrode that dries or loosens, or fatigue."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from emg2vsa.arrays import Floats, Ints, median
from emg2vsa.signals.bias import Shift, left_in, means

FADE, FADE_T, FADE_PRESSES = 0.3, 4.0, 5
"Change of a muscle's ln level over the recording, in units of its standard error, and from how many presses."


@lru_cache(maxsize=16)
def _pairs(n: int) -> tuple[Ints, Ints]:
    """Of n presses, the sooner and the later one of every two."""
    return np.triu_indices(n, 1)


def level_trends(envelopes_v: Floats, offsets: Ints) -> tuple[Floats, Floats]:
    """Change (m,) of each muscle's ln level from the first press to the last, and its standard error; 0 where it is not
    clear (slope by Theil 1950 and Sen 1968).

    envelopes_v : (m, N) of the presses that ``offsets`` (p + 1,) cut, V.
    """
    levels = means(envelopes_v, offsets)
    levels = np.log(np.maximum(levels[:, np.diff(offsets) > 0], 1e-12))
    n = levels.shape[1]
    slopes, errors = np.zeros(len(levels)), np.zeros(len(levels))
    if n < FADE_PRESSES:
        return slopes, errors
    place = np.linspace(-0.5, 0.5, n)
    sooner, later = _pairs(n)
    for muscle, row in enumerate(levels):
        # by medians, for one press with a burst must not hide the trend of the others (Theil 1950, Sen 1968)
        slope = median((row[later] - row[sooner]) / (place[later] - place[sooner]))
        left = row - slope * place
        error = 1.4826 * median(np.abs(left - median(left))) / np.sqrt(float(place @ place))
        if abs(slope) > FADE and abs(slope) > FADE_T * error:
            slopes[muscle], errors[muscle] = slope, error
    return slopes, errors


def level_drift(envelopes_v: Floats, offsets: Ints, slopes: Floats, errors: Floats) -> Shift:
    """What the trends do to a and b of each press, against the first: a muscle that is read at half counts half.

    envelopes_v : (m, N) V, cut by offsets (p + 1,). slopes, errors : (m,) of ln level over the recording.
    """
    levels = means(envelopes_v, offsets)
    p = levels.shape[1]
    if not slopes.any():
        return left_in("level drift", np.zeros(p), np.zeros(p))
    place = np.linspace(0.0, 1.0, p)
    at_start = levels / np.exp(slopes[:, None] * place)
    share = np.nanmean(at_start, axis=1, keepdims=True)
    share /= share.sum()
    change = np.sum(share * np.expm1(slopes[:, None] * place), axis=0)
    error = np.sqrt(np.sum((share * np.exp(slopes[:, None] * place) * place * errors[:, None]) ** 2, axis=0))
    return left_in("level drift", change, change, error)
