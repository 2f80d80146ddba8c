"""How drift enters an interval: taken out where the order of acquisition tells it, else as far as it may reach."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.claims.claim import UNKNOWN, Ends, Found
from emg2vsa.claims.ratio import ratio
from emg2vsa.statistics.drift import Drift, Slope


@dataclass(frozen=True, eq=False)
class Difference:
    """Differences of n people between recordings of each that lie ``apart`` places on the whole, and the drift of such
    values.

    apart : (n,), NaN of a person whose order nobody knows; (0,) of values that are no difference.
    """

    values: Floats
    apart: Floats
    by: Drift

    @property
    def _known(self) -> Floats:
        """``apart``, 0 where it is not known."""
        return np.zeros_like(self.apart) if self.by.order == "unknown" else np.nan_to_num(self.apart)

    @property
    def slope(self) -> Slope:
        """Drift of the mean by the order; without a value where the order does not tell it."""
        differs = self.by.order == "differs" and self._known.any()
        return self.by.by_order.times(float(np.mean(self._known))) if differs else Slope()

    @property
    def freed(self) -> Floats:
        """(n,) values without drift, where the order tells it; one degree of freedom of the scatter went to the
        slope."""
        if self.slope.value != self.slope.value:
            return self.values
        rest = self.values - self.by.by_order.value * self._known
        free = max((rest.size - 1.0) * (self.by.places - 1), 2.0)
        return np.asarray(np.mean(rest) + (rest - np.mean(rest)) * np.sqrt(free / (free - 1)))

    def left(self, confidence: float) -> float:
        """How large a drift of the mean the order does not tell: of people of an unknown order a whole session's."""
        if not self.apart.size:
            return 0.0
        unknown = 1.0 if self.by.order == "unknown" else float(np.mean(np.isnan(self.apart)))
        places = unknown * (self.by.places - 1)
        places += abs(float(np.mean(self._known))) if self.by.order == "same" else 0.0
        return self.by.within.times(places).most(confidence) if places else 0.0


def contrast(top: Difference, bottom: Difference) -> Found:
    """Mean of ``top`` over that of ``bottom``, of the same people, each with what drift may have done to it."""
    values, level = top.freed, bottom.freed
    more = top.slope if top.slope.error > 0 else None
    found = ratio(values, level, more)

    def interval(confidence: float) -> Ends:
        shared = 1 - (1 - confidence) / 3
        moved, unsure = top.left(shared), bottom.left(shared)
        if bottom.slope.error > 0:
            low, high = bottom.slope.interval(shared)
            unsure += (high - low) / 2
        if not (moved or unsure):
            return found.interval(confidence)
        least = abs(float(np.mean(level))) - unsure
        if not least > 0:
            return -np.inf, np.inf
        lows, highs = zip(*(ratio(values, level + by, more).interval(shared) for by in (-unsure, unsure)), strict=True)
        return min(lows) - moved / least, max(highs) + moved / least

    return Found(found.estimate, interval) if found.estimate == found.estimate else UNKNOWN
