"""How drift enters an interval: taken out where the order of acquisition tells it, else as far as it may reach."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.claims.claim import UNKNOWN, Ends, Found, student
from emg2vsa.claims.ratio import ratio
from emg2vsa.statistics.drift import Drift, Slope


def biased(found: Found, most: Callable[[float], float]) -> Found:
    """With a bias whose size is below ``most`` at every confidence; alpha is shared by both (Bonferroni)."""

    def interval(confidence: float) -> Ends:
        shared = (1 + confidence) / 2
        low, high = found.interval(shared)
        return low - most(shared), high + most(shared)

    return Found(found.estimate, interval)


def free_of_drift(estimate: float, error: float, df: float, exposure: float, drift: Drift) -> Found:
    """A difference of two groups whose recordings lie ``exposure`` places apart on average, by Student's t.

    Where the order tells what drift does, it is taken out, with its error; else it may be as large as the trend within
    recordings allows, in either direction. Nobody knows the exposure where the order is unknown: a whole session.
    """
    if drift.order == "differs":
        moved = drift.by_order.times(exposure)
        total = error**2 + moved.error**2
        df = total**2 / (error**4 / df + moved.error**4 / moved.df) if total > 0 else df
        return student(estimate - moved.value, float(np.sqrt(total)), df)
    return biased(student(estimate, error, df), most_by_drift(drift, exposure))


def most_by_drift(drift: Drift, exposure: float) -> Callable[[float], float]:
    """How large a difference can be by drift alone, at every confidence."""
    places = abs(exposure) if drift.order == "same" else drift.places - 1.0
    return lambda confidence: drift.within.times(places).most(confidence) if places else 0.0


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
        """How large a part of the mean drift can be, after ``freed``."""
        if not self.apart.size or not (self.apart.any() or self.by.order == "unknown"):
            return 0.0
        if self.by.order != "differs":
            return most_by_drift(self.by, float(np.mean(self.apart)))(confidence)
        low, high = self.by.by_order.times(float(np.mean(self.apart))).interval(confidence)
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
