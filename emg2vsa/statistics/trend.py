"""Does a value drift with every repetition: fatigue, learning, wear?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, exponent_of, unmasked
from emg2vsa.statistics.clusters import Names, in_order
from emg2vsa.statistics.moments import finite_or_nan


@dataclass(frozen=True, eq=False)
class Trend:
    """blocks (P,) (participants), slope (P,) of each, in units of the value per repetition; NaN where it has none.

    mean, low, high : mean slope and its interval at ``confidence``; per_mean : mean slope over the mean value. t, df,
    p : of no trend. over_blocks : whether the test takes blocks as its sample; with one block
    it takes the repetitions, and speaks of that block only.
    """

    blocks: Names
    slope: Floats
    mean: float
    low: float
    high: float
    per_mean: float
    t: float
    df: float
    p: float
    over_blocks: bool


def trend(block: Names, group: Names, order: ArrayLike, values: ArrayLike, confidence: float = 0.95) -> Trend:
    """Slope of n ``values`` over ``order`` (n,), the number of the repetition; NaN in either leaves a value out.

    Values are compared within their ``group`` (specimen) of their ``block`` (participant) only: one slope a block,
    least squares with a level for every group. The test is Student's t of the slopes of two or more blocks, which needs
    no assumption on how repetitions of one block hang together.
    """
    x, y = (finite_or_nan(np.asarray(unmasked(side), dtype=np.float64)) for side in (order, values))
    there = np.isfinite(x) & np.isfinite(y)
    block, group, x, y = block[there], group[there], x[there], y[there]
    unit = int(exponent_of(y)[0]) if y.size else 0
    y = np.ldexp(y, -unit)  # squares of 1e200 are infinite
    blocks = in_order(block)
    names, code = np.unique(block, return_inverse=True)
    parts = np.split(np.argsort(code, kind="stable"), np.cumsum(np.bincount(code))[:-1])
    of = dict(zip(names.tolist(), parts, strict=False))  # without values there are no names, and one empty part
    rows = [_of_block(group[at], x[at], y[at]) for at in map(of.__getitem__, blocks.tolist())]
    slope, se, free = np.array(rows).reshape(-1, 3).T
    known = np.isfinite(slope)
    count = int(np.count_nonzero(known))
    mean, error, df = np.nan, np.nan, np.nan
    if count > 1:
        mean, df = float(np.mean(slope[known])), count - 1.0
        error = float(np.std(slope[known], ddof=1) / np.sqrt(count))
    elif count == 1:
        mean, error, df = (float(each[known][0]) for each in (slope, se, free))
    error = error if error > 0 else np.nan
    t = mean / error
    reach = float(special.stdtrit(df, 0.5 + 0.5 * confidence)) * error
    level = float(np.mean(y)) if y.size else np.nan
    return Trend(
        blocks=blocks,
        slope=np.ldexp(slope, unit),
        mean=float(np.ldexp(mean, unit)),
        low=float(np.ldexp(mean - reach, unit)),
        high=float(np.ldexp(mean + reach, unit)),
        per_mean=mean / level if level else np.nan,
        t=t,
        df=df,
        p=float(2 * special.stdtr(df, -abs(t))),
        over_blocks=count > 1,
    )


def _of_block(group: Names, x: Floats, y: Floats) -> tuple[float, float, float]:
    """Slope, its standard error and degrees of freedom, a level for every group; NaN where there are none."""
    _, where = np.unique(group, return_inverse=True)
    y = y - y[0]  # exact for near values, so that a large level costs no digits
    count = np.bincount(where)
    dx, dy = (values - (np.bincount(where, values) / count)[where] for values in (x, y))
    sxx, free = float(np.sum(dx**2)), float(y.size - count.size - 1)
    if not sxx > 0 or free < 1:
        return np.nan, np.nan, np.nan
    slope = float(np.sum(dx * dy)) / sxx
    return slope, float(np.sqrt(np.sum((dy - slope * dx) ** 2) / free / sxx)), free
