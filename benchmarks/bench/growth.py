"""How processor time grows with size: exponents with their standard errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.bench.results import CaseResult


@dataclass(frozen=True)
class Growth:
    """One way over the cases of a family. exponent : slope of log time over log size; se : its standard error, NaN
    with two sizes."""

    label: str
    ours: bool
    sizes: tuple[float, ...]
    median_ms: tuple[float, ...]
    exponent: float
    se: float


def growths(cases: Sequence[CaseResult]) -> list[Growth]:
    """Of every way that was measured at two sizes or more."""
    points: dict[tuple[str, bool], list[tuple[float, float]]] = {}
    for case in cases:
        for row in case.rows:
            if row.median_ms:
                points.setdefault((row.label, row.ours), []).append((case.size, row.median_ms))
    grown = []
    for (label, ours), known in points.items():
        if len({size for size, _ in known}) > 1:
            sizes, times = zip(*sorted(known), strict=True)
            grown.append(Growth(label, ours, sizes, times, *exponent(known)))
    return grown


def exponent(points: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Least-squares slope of log y over log x, and its standard error."""
    x, y = np.log(np.array(points)).T
    dx = x - x.mean()
    slope = float(dx @ y / (dx @ dx))
    left = y - y.mean() - slope * dx
    se = np.sqrt(left @ left / (x.size - 2) / (dx @ dx)) if x.size > 2 else np.nan
    return slope, float(se)
