"""What one test, or one estimate, says: the form every method of this package answers in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, Ints


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """One result, free of arrays. Fields that a method does not have are None.

    It fits tests that end in p (F, H, D, U, t), estimates with an interval and no p (ICC), equivalence tests
    (p of the worse side, interval at 1 - 2 alpha) and Bayes factors (statistic "BF01", no p).
    """

    method: str
    "Full name with its variant, e.g. 'one-way ANOVA' or 'Kolmogorov-Smirnov, standardised'."
    n: int
    "Observations that entered."
    statistic_name: str | None = None
    statistic: float | None = None
    df: tuple[float, ...] = ()
    p: float | None = None
    estimate_name: str | None = None
    estimate: float | None = None
    interval: tuple[float, float] | None = None
    "Interval of the estimate, at ``confidence``."
    confidence: float | None = None
    effect_name: str | None = None
    effect_size: float | None = None
    notes: tuple[str, ...] = ()
    "What the reader must know to read the numbers: conditions not met, why something is undefined."


@dataclass(frozen=True, kw_only=True, eq=False)
class Outcomes:
    """What one test says of d designs, or samples; arrays (d,), NaN where undefined.

    df : degrees of freedom, one array each. n : values that entered. effect : size of the effect, where the test has
    one. notes : a text, which may hold {n}, and where it applies.
    """

    method: str
    statistic_name: str
    statistic: Floats
    p: Floats
    n: Ints
    df: tuple[NDArray[Any], ...] = ()
    effect_name: str | None = None
    effect: Floats | None = None
    notes: tuple[tuple[str, NDArray[np.bool_]], ...] = ()

    def outcome(self, i: int = 0) -> Outcome:
        """Design ``i`` alone."""
        return Outcome(
            method=self.method,
            n=int(self.n[i]),
            statistic_name=self.statistic_name,
            statistic=float(self.statistic[i]),
            df=tuple(float(df[i]) for df in self.df),
            p=float(self.p[i]),
            effect_name=self.effect_name,
            effect_size=None if self.effect is None else float(self.effect[i]),
            notes=tuple(text.format(n=self.n[i]) for text, where in self.notes if where[i]),
        )
