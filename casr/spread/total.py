"""The total interval of a spread rate: every known part of its error, not only the scatter of single areas."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from casr.spread.correlated_errors import normal_quantile
from casr.spread.rate import CONFIDENCE


@dataclass(frozen=True)
class TotalInterval:
    """95 % interval of a quantity that is above 0, multiplicative: value times exp(+-1.96 s).

    low, high : of it. parts : name to relative standard error; s is the root of the sum of their squares.
    left_out : what is known to be missing.
    """

    low: float
    high: float
    parts: dict[str, float]
    left_out: tuple[str, ...]

    @property
    def relative_sd(self) -> float:
        """Total relative standard error."""
        return float(np.sqrt(sum(part**2 for part in self.parts.values())))


def total_interval(value: float, parts: Mapping[str, float], left_out: tuple[str, ...] = ()) -> TotalInterval | None:
    """None where the value is not above 0 or a part is not known."""
    kept = {name: float(part) for name, part in parts.items()}
    if not value > 0 or not np.isfinite(list(kept.values())).all():
        return None
    with np.errstate(over="ignore"):  # of a part that says nothing: the interval is from 0 to infinity
        reach = float(np.exp(normal_quantile(CONFIDENCE) * np.sqrt(sum(part**2 for part in kept.values()))))
    return TotalInterval(value / reach, value * reach, kept, left_out)
