"""How far the mean coefficients of profiles may be off, by what was drawn at random: presses of one person, or people.

Means over one person's presses: the error is that of the person's own mean. Specimens are independent of each other,
but successive presses may be alike; ``emg2vsa.statistics.serial`` looks for it in the sum and the difference of a and b
over their SDs, and the larger correlation counts. Means over people: those of one person belong together. The interval
of whatever is linear in the coefficients is Student's t; its degrees of freedom are those of Welch (1947) and
Satterthwaite (1946).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import special

from emg2vsa.arrays import Floats, Ints, mean_of
from emg2vsa.fits import Fits
from emg2vsa.statistics.clusters import clusters_of
from emg2vsa.statistics.serial import serial_correlation

Unit = Literal["press", "person"]
"""What was drawn at random."""


_ROUNDING = 1e-9
"""Share of the largest value: presses that differ by no more are equal."""


@dataclass(frozen=True)
class MeanErrors:
    """Errors of mean a and b of S specimens, from up to R presses of one person, or R people."""

    specimens: tuple[str, ...]
    unit: Unit
    influence: Floats
    "(S, R, 2) shares of the presses or people in the error, whose squares sum to its variance; 0 where there is none."
    count: Ints
    "(S,) presses or people."
    rho: float
    "Correlation of successive presses, 0 where the test does not find one."
    confidence: float

    def half_width(self, weights: Floats) -> Floats:
        """Half of the interval (d,) of d sums of ``weights`` (d, S, 2) times mean a and b of the specimens.

        NaN where a specimen that has a weight was pressed once, or by one person.
        Student's t with the degrees of freedom of Welch (1947) and Satterthwaite (1946).
        """
        most = np.iinfo(np.int64).max
        least = np.min(np.where(np.any(weights != 0, axis=2), self.count, most), axis=1, initial=most)
        parts = np.einsum("dsc,src->dsr", weights, self.influence)
        size = np.max(np.abs(parts), axis=(1, 2), initial=0.0)
        parts = parts / np.where(size > 0, size, 1.0)[:, None, None]  # in any unit squares do not vanish
        if self.unit == "person":
            squares, df = np.sum(np.sum(parts, axis=1) ** 2, axis=1), least - 1.0
        else:
            of_specimen = np.sum(parts**2, axis=2)
            squares = np.sum(of_specimen, axis=1)
            beside = np.sum(of_specimen**2 / np.maximum(self.count - 1, 1), axis=1)
            df = squares**2 / np.where(beside > 0, beside, 1.0) * (1 - self.rho**2) / (1 + self.rho**2)
        half = special.stdtrit(np.maximum(df, 1.0), 0.5 + 0.5 * self.confidence) * np.sqrt(squares) * size
        return np.where(least > 1, half, np.nan)


def mean_errors(
    fits: Fits, rows: NDArray[np.bool_], specimens: Sequence[str], unit: Unit, *, presses_weigh: bool = False
) -> MeanErrors:
    """Errors of the means of the trials ``rows`` (n,) of ``fits``, in the order they were made; of one person where
    the unit is the press.

    presses_weigh : people weigh by their presses, as in the mean over all presses; else each the same.
    """
    a, b = (
        clusters_of(fits.participant[rows], fits.specimen[rows], of[rows], np.ones(int(rows.sum()), dtype=np.bool_))
        for of in (fits.a_v, fits.b_v)
    )
    place = [a.specimens.tolist().index(name) for name in specimens]
    cells = np.stack([a.values[:, place], b.values[:, place]], axis=-1)
    if unit == "press":
        return errors_of(cells[0], specimens, unit, fits.confidence)
    weight = a.count[:, place].T if presses_weigh else None
    means = np.moveaxis(mean_of(np.moveaxis(cells, 2, 3)), 0, 1)
    return errors_of(means, specimens, unit, fits.confidence, weight)


def errors_of(
    values: Floats, specimens: Sequence[str], unit: Unit, confidence: float = 0.95, weight: Ints | None = None
) -> MeanErrors:
    """Errors from a and b (S, R, 2) of presses in the order they were made, or of people; NaN where there is none.

    weight : (S, R) of people in the mean; omitted: the same of all.
    """
    there = np.isfinite(values[..., 0])
    n = np.count_nonzero(there, axis=1)
    share = np.where(there, 1 if weight is None else weight, 0.0)
    share /= np.maximum(np.sum(share, axis=1, keepdims=True), np.finfo(np.float64).tiny)
    filled = np.where(there[..., None], values, 0.0)
    away = np.where(there[..., None], filled - np.einsum("sr,src->sc", share, filled)[:, None], 0.0)
    rho, counted = 0.0, n.astype(np.float64)
    if unit == "press" and n.size:
        sd = np.sqrt(np.sum(away**2, axis=1, keepdims=True))
        sd = np.where(sd > _ROUNDING * np.max(np.abs(filled), axis=1, keepdims=True), sd, np.inf)
        a, b = np.moveaxis(np.where(there[..., None], away / sd, np.nan), -1, 0)
        serial = serial_correlation(np.stack([a + b, a - b]))  # of which neither tells of the other
        most = int(np.argmax(serial.rho))
        rho, counted = float(serial.rho[most]), serial.effective_n[most]
    unbiased = np.sqrt(n / np.maximum(n - 1, 1) * n / np.maximum(counted, np.finfo(np.float64).tiny))
    influence = away * share[..., None] * unbiased[:, None, None]
    return MeanErrors(tuple(specimens), unit, influence, n, rho, confidence)
