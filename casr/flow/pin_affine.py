"""The affine motion of a set of pins by least squares: the flow engine that needs no dense field."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from casr.errors import PinsError
from casr.pins.lattice import pin_pitch_px

FEWEST_PINS = 3
ROUND_ENOUGH = 1e-3  # smallest spread of the pins across a line over the spread along it
OUTLIER_SIGMA = 6.0  # of the residuals' robust scatter
OUTLIER_PITCHES = 1 / 3  # a mistaken pin is off by about one pitch, a bulging skin departs from affine by far less
LEAST_OUTLIER_PX = 0.5
MEDIAN_OF_RAYLEIGH = 1.1774  # median length of a 2-D residual of unit scatter per axis


@dataclass(frozen=True)
class Affine:
    """x' - x = offset_px + matrix (x - centre_px).

    matrix : (2, 2) displacement gradient per frame pair, [[du/dx, du/dy], [dv/dx, dv/dy]].
    offset_px : (2,) motion of the centre. centre_px : (2,) mean of the pins used.
    n : pins used. notes : pins left out.
    """

    matrix: NDArray[np.float64]
    offset_px: NDArray[np.float64]
    centre_px: NDArray[np.float64]
    n: int
    notes: tuple[str, ...] = ()

    def displacement_px(self, points_px: NDArray[np.float64]) -> NDArray[np.float64]:
        """Motion (N, 2) of points (N, 2)."""
        return self.offset_px + (points_px - self.centre_px) @ self.matrix.T


def fit_affine(before_px: NDArray[np.float64], after_px: NDArray[np.float64]) -> Affine:
    """Least-squares affine motion of pins (N, 2) -> (N, 2), row by row; NaN rows are left out.

    A pin off by more than a third of the pitch and by six times the scatter of the others was mistaken for another one:
    the worst is left out and the fit repeated until none stands out; a note says so.

    Raises
    ------
    PinsError : fewer than three pins, or all close to one line.
    """
    before, after = np.asarray(before_px, float), np.asarray(after_px, float)
    rows = seen = np.flatnonzero(np.isfinite(before + after).all(axis=1))
    fit, residual = _fit(before[rows], after[rows])
    while (worst := _mistaken(before[rows], residual)) is not None:
        rows = np.delete(rows, worst)
        fit, residual = _fit(before[rows], after[rows])
    return replace(fit, notes=("pins mistaken for others are left out",)) if len(rows) < len(seen) else fit


def _fit(before: NDArray[np.float64], after: NDArray[np.float64]) -> tuple[Affine, NDArray[np.float64]]:
    """The fit and the length (N,) of each pin's residual."""
    if len(before) < FEWEST_PINS:
        raise _too_few(f"{len(before)}")
    move = after - before
    centre, offset = before.mean(axis=0), move.mean(axis=0)
    arm, rest = before - centre, move - offset
    (xx, xy), (_, yy) = (arm.T @ arm).tolist()
    # eigenvalues and inverse of two by two numbers written out: the library's cost more than the whole fit
    half, apart = (xx + yy) / 2, math.hypot((xx - yy) / 2, xy)
    if not half - apart > ROUND_ENOUGH**2 * (half + apart):
        raise _too_few(f"{len(before)} on one line")
    inverse = np.array([[yy, -xy], [-xy, xx]]) / (xx * yy - xy * xy)
    matrix = (inverse @ (arm.T @ rest)).T
    error = rest - arm @ matrix.T
    squared = np.einsum("ij,ij->i", error, error)
    return Affine(matrix, offset, centre, len(before)), np.sqrt(squared)


def _mistaken(before: NDArray[np.float64], residual: NDArray[np.float64]) -> int | None:
    """The pin that was taken for another one, if there is any."""
    worst = int(residual.argmax())
    scatter = float(np.partition(residual, len(residual) // 2)[len(residual) // 2]) / MEDIAN_OF_RAYLEIGH
    # the pitch costs more than the fit, so it comes last
    if residual[worst] <= max(OUTLIER_SIGMA * scatter, LEAST_OUTLIER_PX) or len(residual) <= FEWEST_PINS + 1:
        return None
    return worst if residual[worst] > OUTLIER_PITCHES * pin_pitch_px(before) else None


def _too_few(found: str) -> PinsError:
    return PinsError(
        "affine fit",
        wanted=f"{FEWEST_PINS} or more pins that are not on one line",
        found=found,
        do="Widen the region, or see why pins are lost: are the frames one press, in order?",
    )
