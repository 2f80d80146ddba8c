"""What one test, or one estimate, says: the form every method of this package answers in."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """One result, free of arrays. Fields that a method does not have are None.

    It fits tests that end in p (F, H, D, U, t), estimates with an interval and no p (ICC, bootstrap), equivalence tests
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
    "Of the estimate, at ``confidence``."
    confidence: float | None = None
    effect_name: str | None = None
    effect_size: float | None = None
    notes: tuple[str, ...] = ()
    "What the reader must know to read the numbers: conditions not met, why something is undefined."
