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
    """Of n people, between recordings of each that lie ``apart`` places on the whole, and the drift of such values."""

    values: Floats
    apart: Floats
    by: Drift

    @property
    def freed(self) -> Floats:
        """Without drift, where the order tells it; one degree of freedom of the scatter went to the slope."""
        if self.by.order != "differs" or not self.apart.any():
            return self.values
        rest = self.values - self.by.by_order.value * self.apart
        free = max((rest.size - 1.0) * (self.by.places - 1), 2.0)
        return np.asarray(np.mean(rest) + (rest - np.mean(rest)) * np.sqrt(free / (free - 1)))

    def left(self, confidence: float) -> float:
        """How large a part of the mean drift can be, after ``freed``. Of an unknown order a whole session's."""
        unknown = self.by.order == "unknown"
        if not self.apart.size or not (self.apart.any() or unknown):
            return 0.0
        apart = self.by.places - 1.0 if unknown else float(np.mean(self.apart))
        if self.by.order != "differs":
            return self.by.within.times(apart).most(confidence) if apart else 0.0
        low, high = self.by.by_order.times(apart).interval(confidence)
        return (high - low) / 2


def contrast(top: Difference, bottom: Difference) -> Found:
    """Mean of ``top`` over that of ``bottom``, of the same people, each with what drift may have done to it."""
    values, by_order = top.freed, top.by.order == "differs"
    slope = top.by.by_order.times(float(np.mean(top.apart))) if by_order and top.apart.size else Slope()
    found = ratio(values, bottom.freed, slope if slope.error > 0 else None)

    def interval(confidence: float) -> Ends:
        shared = 1 - (1 - confidence) / 3
        moved_by, unsure = 0.0 if by_order else top.left(shared), bottom.left(shared)
        if not (moved_by or unsure):
            return found.interval(confidence)
        level = abs(float(np.mean(bottom.freed))) - unsure
        if not level > 0:
            return -np.inf, np.inf
        ends = [
            ratio(values, bottom.freed + shift, slope if slope.error > 0 else None).interval(shared)
            for shift in (-unsure, unsure)
        ]
        return min(low for low, _ in ends) - moved_by / level, max(high for _, high in ends) + moved_by / level

    return Found(found.estimate, interval) if found.estimate == found.estimate else UNKNOWN
