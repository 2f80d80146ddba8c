"""What a way returns, what is known exactly of it, and how far one is from the other."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import numpy as np
from mpmath import mpf

Numbers = Mapping[str, Any]
"""Arrays by name; a library leaves out what it does not give."""
Run = Callable[[], Numbers]
Exact = Mapping[str, Mapping[Any, mpf]]
"""Of some of the numbers: name, index into the array, value."""


def worst_error(exact: Callable[[], Exact]) -> Callable[[Numbers], float]:
    """Largest relative error of the numbers that a way gives, absolute where the truth is zero; NaN counts as 1."""
    known = cache(exact)

    def error(found: Numbers) -> float:
        return max(
            _error(np.asarray(found[name])[index], truth)
            for name, values in known().items()
            if name in found
            for index, truth in values.items()
        )

    return error


def exact_rows(
    exact: Callable[..., Mapping[str, mpf]], names: tuple[str, ...], *tables: np.ndarray, most: int = 20
) -> Exact:
    """Exact numbers of about ``most`` of the rows of the tables; the worst of them stands for all."""
    n = len(tables[0])
    found = {i: exact(*(table[i] for table in tables)) for i in range(0, n, max(1, n // most))}
    return {name: {i: numbers[name] for i, numbers in found.items()} for name in names}


def columns(rows: list[tuple[float, ...]], names: tuple[str, ...]) -> Numbers:
    """Numbers by name from one tuple a row."""
    return dict(zip(names, np.array(rows).T, strict=True))


def collected(rows: list[dict[str, Any]]) -> Numbers:
    """Numbers by name from one dictionary a design."""
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def looped(each: Callable[[Any], dict[str, Any]], designs: Any) -> Run:
    """A test of one design, called for every design in turn."""
    return lambda: collected([each(design) for design in designs])


def _error(value: Any, truth: mpf) -> float:
    if not np.isfinite(value):
        return 1.0
    error = abs(mpf(float(value)) - truth)
    return float(error / abs(truth) if truth else error)
