"""Means and sums of squares of groups, free of cancellation, overflow and underflow: where tests on means start."""

from __future__ import annotations

from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from emg2vsa.arrays import Floats, Ints, exponent_of, uniform, unmasked
from emg2vsa.errors import DataError

_ROUNDING = 8 * np.finfo(np.float64).eps
"""Largest error of a difference of means, over the largest value they were taken of."""
_LEAST = 1e-180  # sums of squares between this and its inverse are those that scaled values would give
_LONGEST = 10_000  # of longer groups BLAS shares one among threads, and its last bit shows it


class GroupMoments(NamedTuple):
    """d designs of up to k groups of up to n values. Numbers are in units of 2^unit of the data, per design.

    counts (d, k). offset (d, k): means relative to the first value of the design, 0 for an empty group. squares (d, k):
    sums of squared deviations from the group's mean. deviation (d, k, n): those deviations, 0 where there is no value.
    there (d, k, n): where there is one, None for everywhere. unit (d,): binary exponents, None where all are 0.
    mean (d, k): in the data's unit, NaN where empty. each : values of a group where all have the same, else 0.
    """

    counts: Ints
    offset: Floats
    squares: Floats
    deviation: Floats
    there: NDArray[np.bool_] | None
    unit: NDArray[np.int32] | None
    mean: Floats
    each: int

    @property
    def valid(self) -> NDArray[np.bool_]:
        """(d, k, n) where there is a value."""
        return uniform(self.deviation.shape, True) if self.there is None else self.there

    def to_data(self, scaled: Floats) -> Floats:
        """Numbers (d, ...) of the first power of the data, back in the data's own unit: a scalar or more of each
        design."""
        if self.unit is None:
            return scaled
        return np.asarray(np.ldexp(scaled, self.unit.reshape(-1, *(1,) * (scaled.ndim - 1))))


def group_moments(values: ArrayLike) -> GroupMoments:
    """Moments of ``values`` (d, k groups, n a group), or of one design (k, n); NaN: no value there.

    Every group is shifted by one of its own values and then centred: on float64 input that reaches what exact
    arithmetic on the same doubles gives for all of NIST's ANOVA sets (benchmarks/nist.py). Decimal, Fraction and int
    objects are accepted (None: no value); their differences are taken exactly. DataError for another shape.
    """
    with np.errstate(invalid="ignore", over="ignore"):
        return unguarded_moments(values)


def unguarded_moments(values: ArrayLike) -> GroupMoments:
    """The same for a caller who has silenced the warnings of invalid numbers and of overflow."""
    doubles, origin = _shifted(values)
    return _of_whole_groups(doubles, origin) or _of_groups(finite_or_nan(doubles), origin)


def _of_whole_groups(doubles: Floats, origin: Floats | None) -> GroupMoments | None:
    """Of designs without a gap and in no need of a unit; None where a group has no spread, too, or one value."""
    d, k, n = doubles.shape
    if n > _LONGEST:
        return None
    start = doubles[..., 0]
    deviation = doubles - start[..., None]
    inner = np.einsum("ijk->ij", deviation)
    inner /= n
    deviation -= inner[..., None]
    squares = np.vecdot(deviation, deviation)
    if np.count_nonzero((squares > _LEAST) & (squares < 1 / _LEAST)) < d * k:
        return None
    first = start[:, :1]
    offset = start - first
    offset += inner
    mean = first + offset
    if origin is not None:
        mean += origin[:, None]
    return GroupMoments(uniform((d, k), n), offset, squares, deviation, None, None, mean, n)


def _of_groups(doubles: Floats, origin: Floats | None) -> GroupMoments:
    valid = np.isfinite(doubles)
    count = valid.sum(axis=2)
    filled = np.where(valid, doubles, 0.0)
    d, k, n = filled.shape
    unit = exponent_of(filled.reshape(d, k * n))[:, 0] + 1
    filled = np.ldexp(filled, -unit[:, None, None])
    design = np.arange(d)[:, None]
    start = filled[design, np.arange(k), valid.argmax(axis=2)]
    shifted = np.where(valid, filled - start[..., None], 0.0)
    inner = shifted.sum(axis=2) / np.maximum(count, 1)
    deviation = np.where(valid, shifted - inner[..., None], 0.0)
    design_start = start[design, (count > 0).argmax(axis=1)[:, None]]
    offset = np.where(count > 0, start - design_start + inner, 0.0)
    at = np.ldexp(np.where(count > 0, design_start + offset, np.nan), unit[:, None])
    squares, mean = (deviation**2).sum(axis=2), (0.0 if origin is None else origin[:, None]) + at
    return GroupMoments(count, offset, squares, deviation, valid, unit, mean, common_count(count))


def common_count(count: Ints) -> int:
    """The number of values of a group (d, k) where all have the same, else 0."""
    each = int(count.item(0)) if count.size else 0
    return each if np.count_nonzero(count == each) == count.size else 0


def shifted_doubles(values: ArrayLike) -> tuple[Floats, Floats]:
    """``values`` of shape (d, k, n), or (k, n) as one design, as float64, and the origin (d,) they are relative to.

    float64 input comes back as it is, relative to 0, masked values as NaN. Decimal, Fraction and int objects (None:
    NaN) come back relative to the first of their design. DataError for other shapes, groups of unequal length, and what
    is infinite or not a number.
    """
    doubles, origin = _shifted(values)
    return finite_or_nan(doubles), np.zeros(len(doubles)) if origin is None else origin


def _shifted(values: ArrayLike) -> tuple[Floats, Floats | None]:
    """The same, what is infinite not yet refused, and no origin of float64 input."""
    try:
        array = np.asarray(unmasked(values))
        kind = array.dtype.kind
        if kind == "c":
            raise TypeError("complex numbers")
        doubles = array if kind == "O" else np.asarray(array, dtype=np.float64)
    except (ValueError, TypeError) as error:
        raise _not_a_design(str(error)) from error
    if doubles.ndim == 2:
        doubles = doubles[None]
    if doubles.ndim != 3 or 0 in doubles.shape[1:]:
        raise _not_a_design(f"shape {array.shape}")
    if kind != "O":
        return doubles, None
    pairs = [_shift_design(list(design.flat)) for design in doubles]
    return np.array([row for row, _ in pairs]).reshape(doubles.shape), np.array([origin for _, origin in pairs])


def finite_or_nan(values: Floats) -> Floats:
    """The same values, of any shape. DataError where one is infinite: that is neither a number nor missing."""
    if count := int(np.count_nonzero(np.isinf(values))):
        raise DataError(
            "values to test", wanted="finite numbers, and NaN where one is missing",
            found=f"{count} of {values.size} infinite", do="Correct what made them, or give NaN for a missing value.",
        )  # fmt: skip
    return values


def without_rounding(squares: ArrayLike, n: ArrayLike, largest: ArrayLike) -> Floats:
    """Sums of ``squares`` of ``n`` deviations, 0 where rounding alone can make them as large: below n (8 eps)^2 of the
    ``largest`` value, squared, that the deviations were taken of. Decimals such as 0.1 are rounded before they differ.
    """
    floor = np.asarray(n, dtype=np.float64) * (_ROUNDING * np.asarray(largest, dtype=np.float64)) ** 2
    return np.where(np.asarray(squares) > floor, squares, 0.0)


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


def row_moments(values: ArrayLike) -> GroupMoments:
    """Moments of the rows of ``values`` (k, n), or of one row (n,), each a design of one group; NaN: no value there.

    DataError for other shapes.
    """
    rows = np.atleast_2d(np.asarray(unmasked(values), dtype=np.float64))
    if rows.ndim != 2:
        do = "Give one sample a row, shorter ones padded with NaN."
        raise DataError("samples", wanted="numbers of shape (samples, values)", found=f"shape {rows.shape}", do=do)
    return group_moments(rows[:, None, :] if rows.shape[1] else np.full((len(rows), 1, 1), np.nan))
