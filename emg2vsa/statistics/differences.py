"""Order statistics of all differences between two samples, without writing all of them down where they are many.

How many differences are up to v takes one search of the sorted samples. A subsample gives a first bracket, the counts
at its ends the next, until few enough differences are left between the ends to be sorted.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats, Ints

_FEW = 1 << 14
"""Differences of a pair that are sorted together with those of all other pairs."""
_MANY = 1 << 18
"""Differences that are sorted at once."""
_SAMPLE = 1000


def differences_at(left: Floats, right: Floats, places: Ints) -> Floats:
    """Differences left minus right at ``places`` (p, d, q) of their ascending order, for pairs (d, q, n); NaN absent.

    A place outside the differences of a pair takes the nearest.
    """
    d, q, n = left.shape
    if n * right.shape[2] <= _FEW:
        ordered = np.sort(
            (left[..., :, None] - right[..., None, :]).reshape(d, q, n * right.shape[2]), axis=2
        )  # NaN last
        index = np.clip(places, 0, max(ordered.shape[2] - 1, 0))
        return np.stack([np.take_along_axis(ordered, at[..., None], axis=2)[..., 0] for at in index])
    found = np.full(places.shape, np.nan)
    for i, j in np.ndindex(d, q):
        x, y = (np.sort(side[i, j][~np.isnan(side[i, j])], kind="stable") for side in (left, right))
        if x.size and y.size:
            found[:, i, j] = _at(x, y, np.clip(places[:, i, j], 0, x.size * y.size - 1))
    return found


def _at(x: Floats, y: Floats, places: Ints) -> Floats:
    """Differences of the sorted ``x``, ``y`` at ``places`` (p,)."""
    if x.size * y.size <= _MANY:
        return np.asarray(np.partition(np.subtract.outer(x, y).ravel(), np.unique(places))[places])
    samples = _Samples.of(x, y)
    sketch = np.sort(np.subtract.outer(*(side[:: max(1, side.size // _SAMPLE)] for side in (x, y))).ravel())
    found, window = np.empty(places.size), None
    for k in np.argsort(places).tolist():
        place = int(places[k])
        if window is None or not window.first <= place < window.end:
            window = _window(samples, sketch, place)
        found[k] = window.value(place)
    return found


@dataclass(frozen=True)
class _Samples:
    """Distinct values of two samples, ascending, how often they occur, and how many of the second lie before each."""

    x: Floats
    y: Floats
    x_count: Ints
    y_count: Ints
    y_before: Ints

    @classmethod
    def of(cls, x: Floats, y: Floats) -> _Samples:
        (x, x_count), (y, y_count) = _distinct(x), _distinct(y)
        return cls(x, y, x_count, y_count, np.concatenate([[0], np.cumsum(y_count)]))

    def up_to(self, v: float) -> _Cut:
        at = np.searchsorted(self.y, self.x - v, side="left")
        return _Cut(v, at, int(np.dot(self.x_count, self.y_before[-1] - self.y_before[at])))


def _distinct(ordered: Floats) -> tuple[Floats, Ints]:
    """Values that occur and how often."""
    first = np.flatnonzero(np.concatenate([[True], ordered[1:] != ordered[:-1]]))
    return ordered[first], np.diff(first, append=ordered.size)


@dataclass(frozen=True)
class _Cut:
    """All differences up to ``v``: those of value i of x with the values of y from ``at`` (i) on; ``count`` of them."""

    v: float
    at: Ints
    count: int


@dataclass(frozen=True)
class _Window:
    """Sorted differences at the places ``first`` to ``end`` - 1, and the place of the last of each alike."""

    first: int
    end: int
    values: Floats
    last: Ints

    def value(self, place: int) -> float:
        return float(self.values[np.searchsorted(self.last, place - self.first, side="left")])


def _window(samples: _Samples, sketch: Floats, place: int) -> _Window:
    """The differences around ``place``, few enough to be sorted."""
    low, high = _first_bracket(samples, sketch, place)
    total = float(samples.x_count.sum()) * float(samples.y_count.sum())
    while (left := int(np.sum(low.at - high.at))) > _MANY:
        inside = high.count - low.count
        aim = (place + 0.5 - low.count) / inside
        # the error of a straight line between the ends grows with how much lies between them
        margin = min(4 * inside / total + _MANY / (4.0 * left), 0.25)
        start, width = low.v, high.v - low.v
        for share in (aim - margin, aim + margin):
            if 0 < share < 1:
                low, high = _narrowed(samples, low, high, start + share * width, place)
        if int(np.sum(low.at - high.at)) > left / 2:
            middle = low.v + (high.v - low.v) / 2
            if not low.v < middle < high.v:
                break
            low, high = _narrowed(samples, low, high, middle, place)
    return _sorted_between(samples, low, high)


def _first_bracket(samples: _Samples, sketch: Floats, place: int) -> tuple[_Cut, _Cut]:
    least, most = samples.x[0] - samples.y[-1], samples.x[-1] - samples.y[0]
    none = _Cut(float(np.nextafter(least, -np.inf)), np.full(samples.x.size, samples.y.size), 0)
    low, high = (
        none,
        _Cut(float(most), np.zeros(samples.x.size, dtype=np.int64), int(samples.x_count.sum() * samples.y_count.sum())),
    )
    share = place / high.count * sketch.size
    for at in (share - sketch.size / _SAMPLE, share + sketch.size / _SAMPLE):
        if 0 <= at < sketch.size:
            low, high = _narrowed(samples, low, high, float(sketch[int(at)]), place)
    return low, high


def _narrowed(samples: _Samples, low: _Cut, high: _Cut, v: float, place: int) -> tuple[_Cut, _Cut]:
    if not low.v < v < high.v:
        return low, high
    cut = samples.up_to(v)
    return (cut, high) if cut.count <= place else (low, cut)


def _sorted_between(samples: _Samples, low: _Cut, high: _Cut) -> _Window:
    lengths = low.at - high.at
    of_x = np.repeat(np.arange(lengths.size), lengths)
    of_y = np.arange(of_x.size) - np.repeat(np.cumsum(lengths) - lengths - high.at, lengths)
    values = samples.x[of_x] - samples.y[of_y]
    if values.size == high.count - low.count:  # every value occurs once
        return _Window(low.count, high.count, np.sort(values), np.arange(values.size))
    order = np.argsort(values)
    weights = samples.x_count[of_x] * samples.y_count[of_y]
    return _Window(low.count, high.count, values[order], np.cumsum(weights[order]) - 1)
