"""Order of acquisition and drift: what a comparison of groups owes to when each group was recorded.

A recording is one group (specimen) of one block (person): R values (presses) in a row, at a place in the order in which
all recordings of its session were made. Drift moves values from place to place. Where the order differs between blocks,
least squares tell it from blocks and groups, and a difference of groups can be freed of it. Where every block has the
same order, or nobody knows the order, drift looks like a difference of groups. Then the trend of the values within
recordings says how large it can be: a recording further on, as many values further on.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats, Ints
from emg2vsa.statistics.clusters import Names
from emg2vsa.statistics.moments import finite_or_nan
from emg2vsa.statistics.trend import trend

Order = Literal["differs", "same", "unknown"]
"""Whether the order of the groups differs between blocks; "same" also where it does in one block alone, or where blocks
share a few orders that leave a group at one place in most of them: a drift that is not straight would stay."""
_COLLINEAR = 1e-9
"""Share of the squares of places, below which blocks and groups tell the place."""


@dataclass(frozen=True)
class Slope:
    """Change of the value from a place to the next, with its standard error and degrees of freedom; NaN: unknown."""

    value: float = np.nan
    error: float = np.nan
    df: float = np.nan

    def interval(self, confidence: float) -> tuple[float, float]:
        """Low and high, by Student's t."""
        reach = float(special.stdtrit(self.df, 0.5 + 0.5 * confidence)) * self.error
        return self.value - reach, self.value + reach

    def most(self, confidence: float) -> float:
        """The largest size that the interval holds; infinite where nothing is known."""
        low, high = self.interval(confidence)
        return max(abs(low), abs(high)) if low == low else np.inf

    def times(self, factor: float) -> Slope:
        """The change over ``factor`` places."""
        return Slope(self.value * factor, self.error * abs(factor), self.df)


@dataclass(frozen=True)
class Drift:
    """by_order : from the places of the recordings, unknown unless ``order`` is "differs". within : from the trend
    within recordings, taken on for as many values as a recording has. places : recordings of the longest session.
    """

    order: Order
    by_order: Slope
    within: Slope
    places: int

    @property
    def session(self) -> Slope:
        """Change from the first recording of a session to its last, by the order where it tells."""
        return (self.by_order if self.order == "differs" else self.within).times(self.places - 1)


def drift(
    block: Names, group: Names, place: Floats, repetition: Floats, values: Floats, unit: Names | None = None
) -> Drift:
    """Drift of n values (all arrays (n,)); NaN is left out.

    place : of the value's recording in its session, NaN where nobody knows: a block with such a recording tells nothing
    of the order, which is unknown unless more than half of the blocks tell it. repetition : of the value within its
    recording. unit : over which trends within recordings are averaged; blocks unless given.
    """
    there = np.isfinite(finite_or_nan(values))
    unit = (block if unit is None else unit)[there]
    block, group = block[there], group[there]
    place, repetition, values = place[there], repetition[there], values[there]
    if not values.size:
        return Drift("unknown", Slope(), Slope(), 0)
    keys = np.stack([np.unique(each, return_inverse=True)[1] for each in (block, group, place)], axis=1)
    _, first, recording, count = np.unique(keys, axis=0, return_index=True, return_inverse=True, return_counts=True)
    recording = recording.ravel()
    mean = np.bincount(recording, values) / count
    places = int(np.bincount(np.unique(keys[first, 0], return_inverse=True)[1]).max())
    within = _within(unit, np.char.mod("%d", recording), repetition, values).times(float(np.median(count)))
    levels, at = keys[first, :2], place[first]
    told = ~np.isin(levels[:, 0], levels[~np.isfinite(at), 0])
    if 2 * np.unique(levels[told, 0]).size <= np.unique(levels[:, 0]).size:
        return Drift("unknown", Slope(), within, places)
    by_order = None if _few_orders(levels[told], at[told]) else _by_order(levels[told], at[told], mean[told])
    return Drift("same" if by_order is None else "differs", by_order or Slope(), within, places)


def _few_orders(levels: Ints, place: Floats) -> bool:
    """Whether half as many orders as blocks, or fewer, leave a group at one place in more than half of the blocks.

    levels : (n, 2) block and group of n recordings. False where a block lacks a group, or there is one block.
    """
    row, column = (np.unique(each, return_inverse=True)[1] for each in levels.T)
    blocks, groups = int(row.max()) + 1, int(column.max()) + 1
    if place.size != blocks * groups or blocks < 2:
        return False
    table = np.empty((blocks, groups))
    table[row, column] = place
    rank = np.argsort(np.argsort(table, axis=1), axis=1)
    share = max(float(np.mean(rank == k, axis=0).max()) for k in range(groups))
    return share > 0.5 and 2 * len(np.unique(rank, axis=0)) <= blocks


def _within(unit: Names, recording: Names, repetition: Floats, values: Floats) -> Slope:
    """Per repetition."""
    found = trend(unit, recording, repetition, values)
    slope = found.slope[np.isfinite(found.slope)]
    if slope.size > 1:
        return Slope(float(np.mean(slope)), float(np.std(slope, ddof=1) / np.sqrt(slope.size)), slope.size - 1.0)
    if not slope.size:
        return Slope()
    # a slope of exactly 0 has t = 0, and its error from the interval
    error = found.mean / found.t if found.t else found.high / float(special.stdtrit(found.df, 0.975))
    return Slope(found.mean, error, found.df)


def _by_order(levels: Ints, place: Floats, mean: Floats) -> Slope | None:
    """Least squares with a level for every block and every group; None where these tell place, or but for one block.

    The error is that of least squares, or that of a mean of the slopes of blocks, weighted by what each tells of place,
    where this is larger: people drift at rates of their own. Its degrees of freedom count blocks by that weight.
    """
    both = np.stack([place - place.mean(), mean - mean.mean()], axis=1)
    left, rank = _without_levels(levels, both)
    x, y = left.T
    squares, free = float(x @ x), place.size - rank - 1
    if free < 1 or not squares > _COLLINEAR * float(both[:, 0] @ both[:, 0]):
        return None
    value = float(x @ y) / squares
    rest = y - value * x
    unit = levels[:, 0] if np.ptp(levels[:, 0]) else levels[:, 1]
    weight, score = (np.bincount(unit, x * each) / squares for each in (x, rest))
    alone = float(weight @ weight)
    if alone > 0.5 + _COLLINEAR:
        return None
    error = np.sqrt(max(float(rest @ rest) / free / squares, float(score @ score) / (1 - alone)))
    return Slope(value, float(error), min(1 / alone - 1, float(free)))


def _without_levels(levels: Ints, values: Floats) -> tuple[Floats, int]:
    """Residuals (n, k) of least squares with a level for every block and every group, and the rank of these levels.

    Blocks are thousands of people, so their means are taken out first (Frisch and Waugh 1933); groups are few.
    """
    block, group = (np.unique(each, return_inverse=True)[1] for each in levels.T)
    count = np.bincount(block)

    def apart(table: Floats) -> Floats:
        means = np.stack([np.bincount(block, column) for column in table.T], axis=1) / count[:, None]
        return table - means[block]

    design, left = apart((group[:, None] == np.arange(group.max() + 1)).astype(np.float64)), apart(values)
    found, _, rank, _ = np.linalg.lstsq(design, left, rcond=None)
    return left - design @ found, count.size + int(rank)
