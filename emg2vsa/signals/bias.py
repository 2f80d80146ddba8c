"""The budget of a press: what moves its a and b away from the muscle's, cause by cause, and how well that is known.

A cause is corrected where it can be; what it may have left, and the error of its correction, stand here. The verdict of
a press compares the sum with the half width of its own interval (``emg2vsa.fits``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, get_args

import numpy as np

from emg2vsa.arrays import Floats, Ints

Cause = Literal[
    "rest level", "mains", "hum at the touch", "contact artefact", "spikes and bursts", "lag", "clock", "lost samples",
    "clipping", "crosstalk", "filters in the file", "level drift", "zero of force",
]  # fmt: skip
CAUSES: tuple[Cause, ...] = get_args(Cause)
TOLD = 0.005
"Share of b from which on the largest cause of a press is named."
LEAST = -0.9
"A cause that leaves less than a tenth of b is not divided out."
MUSCLE_SHARE, MUSCLE_S = 0.3, 0.3
"""A muscle's own lag is off by so much of itself, rms, alike in all presses, for it smooths (people made of motor
units, benchmarks.motor_units: 170 ms are found of 120). A longer lag is of clocks."""


class Shift(NamedTuple):
    """What one cause does to the p presses of a recording; all (p,), signed.

    b : change of b that is left in the press, as a share of the muscle's b. a : that of a, as a share of the mean
    level. b_se : standard error of the former. corrected : change that was taken out, as a share of b.
    """

    cause: Cause
    a: Floats
    b: Floats
    b_se: Floats
    corrected: Floats


def left_in(cause: Cause, a: Floats, b: Floats, b_se: Floats | float = 0.0) -> Shift:
    """A cause that stays in the press; arrays as in ``Shift``, (p,)."""
    return Shift(cause, a, b, b_se + np.zeros(b.size), np.zeros(b.size))


def taken_out(cause: Cause, b: Floats, b_se: Floats | float) -> Shift:
    """A cause that was corrected; b : (p,) the change that it made."""
    return Shift(cause, np.zeros(b.size), np.zeros(b.size), b_se + np.zeros(b.size), b)


@dataclass(frozen=True)
class BiasBudget:
    """Fields of ``Shift`` by cause and press, (c, p) each; a cause of which nothing was seen has no row."""

    causes: tuple[Cause, ...]
    a: Floats
    b: Floats
    b_se: Floats
    corrected: Floats

    @staticmethod
    def of(shifts: Sequence[Shift], n_presses: int) -> BiasBudget:
        """The sum of the shifts of each cause; what is not known (NaN) counts as none."""
        seen = [one for one in shifts if any(((each != 0) & ~np.isnan(each)).any() for each in one[1:])]
        causes = tuple(cause for cause in CAUSES if any(one.cause == cause for one in seen))
        rows = np.zeros((4, len(causes), n_presses))
        for one in seen:
            rows[:, causes.index(one.cause)] += np.nan_to_num(np.array(one[1:]), posinf=0.0, neginf=0.0)
        return BiasBudget(causes, *rows)

    @staticmethod
    def joined(parts: Sequence[BiasBudget]) -> BiasBudget:
        """The presses of several recordings."""
        causes = tuple(cause for cause in CAUSES if any(cause in part.causes for part in parts))
        rows = []
        for part in parts:
            own = np.zeros((4, len(causes), part.b.shape[1]))
            at = [causes.index(cause) for cause in part.causes]
            own[:, at] = np.array([part.a, part.b, part.b_se, part.corrected])
            rows.append(own)
        return BiasBudget(causes, *np.concatenate(rows, axis=2))

    @property
    def total(self) -> Floats:
        """(p,) share by which all causes together change b."""
        return np.asarray(np.maximum(np.prod(1 + self.b, axis=0) - 1, LEAST))

    @property
    def total_se(self) -> Floats:
        """(p,) standard error of ``total``."""
        return np.asarray(np.sqrt(np.sum(self.b_se**2, axis=0)))

    @property
    def largest(self) -> tuple[str, ...]:
        """(p,) the cause that is largest by size and error together; "" where none reaches ``TOLD``."""
        if not self.causes:
            return ("",) * int(self.b.shape[1])
        size = np.hypot(self.b, self.b_se)
        rows: list[int] = np.argmax(size, axis=0).tolist()
        tops: list[float] = size.max(axis=0).tolist()
        return tuple(self.causes[row] if top > TOLD else "" for row, top in zip(rows, tops, strict=True))


def muscle_error_s(lag_s: float) -> float:
    """Standard error of a lag that may be a muscle's own: activity comes first, by no more than muscles take."""
    return MUSCLE_SHARE * lag_s if 0 < lag_s <= MUSCLE_S else 0.0


def line_change(
    x: Floats, y: Floats, true_x: Floats, true_y: Floats, level: Floats, offsets: Ints
) -> tuple[Floats, Floats]:
    """Changes of a over the mean level, and of b over itself, (p,) each: the line of y on x against that of ``true_y``
    on ``true_x``, press by press; all (N,), weighted by 1 / level^2.

    NaN for presses of fewer than ten samples, or without a slope.
    """
    counts = np.diff(offsets)
    if x.size == 0:
        unknown = np.full(counts.size, np.nan)
        return unknown, unknown
    top = np.repeat(means(level, offsets), counts)
    with np.errstate(divide="ignore", invalid="ignore"):
        weights = np.where(top > 0, (top / np.maximum(level, 0.1 * top)) ** 2, 1.0)
        if true_x is x:
            (a, b), (true_a, true_b) = _lines(x, (y, true_y), weights, offsets)
        else:
            ((a, b),), ((true_a, true_b),) = (_lines(*of, weights, offsets) for of in ((x, (y,)), (true_x, (true_y,))))
        shares = (a - true_a) / means(true_y, offsets), b / true_b - 1
    known = (counts >= 10) & np.isfinite(shares[1])
    return np.where(known, shares[0], np.nan), np.where(known, shares[1], np.nan)


def _lines(x: Floats, of: Sequence[Floats], weights: Floats, offsets: Ints) -> list[tuple[Floats, Floats]]:
    """Weighted intercepts and slopes (p,) of each of the y."""
    total = means(weights, offsets)
    centre = means(weights * x, offsets) / total
    lever = weights * (x - np.repeat(centre, np.diff(offsets)))
    leverage = means(lever * x, offsets)
    slopes = [means(lever * y, offsets) / leverage for y in of]
    return [(means(weights * y, offsets) / total - b * centre, b) for y, b in zip(of, slopes, strict=True)]


def means(values: Floats, offsets: Ints) -> Floats:
    """Means (..., p) of the rows (..., N) between successive offsets; NaN where empty."""
    counts = offsets[1:] - offsets[:-1]
    if counts.all() and counts.size:
        return np.asarray(np.add.reduceat(values, offsets[:-1], axis=-1) / counts)
    with np.errstate(invalid="ignore"):
        sums = np.add.reduceat(np.concatenate((values, np.zeros((*values.shape[:-1], 1))), axis=-1), offsets, axis=-1)
        return np.asarray(np.where(counts > 0, sums[..., :-1], 0.0) / counts)
