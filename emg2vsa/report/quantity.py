"""A number, or a word, of the report under a flat name."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from emg2vsa.arrays import Floats

Quantity = str | int | float | bool
Items = Iterator[tuple[str, Quantity]]


def least(values: Floats) -> float:
    """Smallest finite value, or NaN."""
    return float(np.min(values, initial=np.inf, where=np.isfinite(values))) if np.isfinite(values).any() else np.nan


def most(values: Floats) -> float:
    """Largest finite value, or NaN."""
    return -least(-values)
