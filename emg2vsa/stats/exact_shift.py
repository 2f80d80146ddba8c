"""Numbers that float64 cannot hold, brought into its reach: differences taken in exact arithmetic."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats
from emg2vsa.errors import DataError


def shifted_doubles(values: ArrayLike) -> tuple[Floats, Floats]:
    """``values`` of shape (d, k, n), or (k, n) as one design, as float64, and the origin (d,) they are relative to.

    float64 input comes back as it is, relative to 0. Decimal, Fraction and int objects (None: NaN) come back relative
    to the first of their design. DataError for other shapes, groups of unequal length, or what is not a number.
    """
    try:
        array = np.asarray(values)
        doubles = array if array.dtype == object else array.astype(np.float64)
    except (ValueError, TypeError) as error:
        raise _not_a_design(str(error)) from error
    if doubles.ndim == 2:
        doubles = doubles[None]
    if doubles.ndim != 3 or 0 in doubles.shape[1:]:
        raise _not_a_design(f"shape {array.shape}")
    if doubles.dtype != object:
        return doubles, np.zeros(len(doubles))
    pairs = [_shift_design(list(design.flat)) for design in doubles]
    return np.array([row for row, _ in pairs]).reshape(doubles.shape), np.array([origin for _, origin in pairs])


def _shift_design(values: list[Any]) -> tuple[list[float], float]:
    try:
        exact = [None if value is None or value != value else Fraction(value) for value in values]
    except (TypeError, ValueError, OverflowError) as error:
        raise _not_a_design(str(error)) from error
    origin = next((value for value in exact if value is not None), Fraction(0))
    return [np.nan if value is None else float(value - origin) for value in exact], float(origin)


def _not_a_design(found: str) -> DataError:
    return DataError(
        "analysis of variance",
        wanted="numbers of shape (designs, groups, values) or (groups, values)",
        found=found,
        do="Pad shorter groups with NaN.",
    )
