"""Restricted likelihood of the mixed model of a study: specimens fixed, participants random, any number of gaps.

y = mean of the specimen + participant + participant by specimen + repetition. The values of a cell (participant by
specimen) enter through their number n and mean only, besides the squares within cells. With the variances relative to
that of repetitions, t1 of participants and t2 of participants by specimens, the cell means of one participant have the
covariance diag(1 / n + t2) + t1 1 1', whose inverse and determinant are known (Sherman and Morrison 1950). So the
restricted likelihood (Patterson and Thompson 1971) costs a table of participants by specimens, and not all values.
Its largest value is sought where no variance is negative; a variance may be exactly 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import optimize

from emg2vsa.arrays import Floats, exponent_of, unmasked
from emg2vsa.statistics.moments import finite_or_nan, without_rounding
from emg2vsa.statistics.outcome import Outcome

METHOD = "linear mixed model, REML, Satterthwaite df"
LARGEST = 1e12
"""Ratio of variances beyond which the search does not go."""
TINY_STEP = 1e-30
"""Size of the complex step: derivatives without a difference of numbers (Squire and Trapp 1998)."""
_STEPS = 100
_GRID = (0.0, 1e-3, 1e-2, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0, 1e4, 1e6, 1e8, 1e10, LARGEST)
"""Ratios at which the search may begin: the likelihood can have two tops."""
_SETTLED = 1e-14
LEAST_ERROR = 1e-9
"""Smallest variance of repetitions, in units of the best one, that `by_variances` is asked for."""
_NEAR = 1e-8
"""Relative step below which Newton's steps that no longer shrink have reached the rounding of the likelihood."""
Cost = Callable[[NDArray[Any]], tuple[Any, NDArray[Any]]]
"""-2 log restricted likelihood and its slopes at parameters that may be complex; then only the slopes count."""


@dataclass(frozen=True)
class Cells:
    """count, mean : (P, S), 0 where a cell is empty. within : sum of squares within cells. n : all values."""

    count: Floats
    mean: Floats
    within: float
    n: int

    @property
    def free(self) -> int:
        """Values less fixed effects."""
        return self.n - int(self.count.shape[1])


@dataclass(frozen=True)
class At:
    """The model at ratios t1, t2, which may be complex: see `solve`."""

    beta: NDArray[Any]
    inverse: NDArray[Any]
    projected: NDArray[Any]
    residual_squares: Any
    logs: Any
    residual_slopes: NDArray[Any]
    log_slopes: NDArray[Any]

    def deviance(self, free: int) -> Any:
        """-2 log restricted likelihood without its constants, the variance of repetitions at its best."""
        return free * np.log(self.residual_squares / free) + self.logs

    def slope(self, free: int) -> NDArray[Any]:
        """(2,) derivatives of `deviance` along t1 and t2."""
        return np.asarray(free * self.residual_slopes / self.residual_squares + self.log_slopes)


def _cells_of(values: Floats) -> tuple[Cells, float, int, str]:
    """Cells of the values less their first, scaled by 2**-unit to below 1, and why they cannot be fitted, or ""."""
    there = np.isfinite(finite_or_nan(values))
    count = np.count_nonzero(there, axis=2).astype(np.float64)
    n = int(count.sum())
    origin = float(values[there][0]) if n else 0.0
    shifted = np.where(there, values - origin, 0.0)
    unit = int(exponent_of(np.max(np.abs(shifted)))) if n else 0
    shifted = np.ldexp(shifted, -unit)
    # a cell is centred on its own first value: equal decimals then do not differ by the rounding of their mean
    start = np.take_along_axis(shifted, np.argmax(there, axis=2)[..., None], axis=2)
    inner = np.where(there, shifted - start, 0.0)
    inner_mean = inner.sum(axis=2) / np.maximum(count, 1)
    squares = np.sum((inner - inner_mean[..., None]) ** 2, where=there)
    largest = np.max(np.abs(shifted), initial=abs(np.ldexp(origin, -unit)))
    within = float(without_rounding(squares, n, largest))
    cells = Cells(count, start[..., 0] + inner_mean, within, n)
    if min(count.shape) < 2 or np.count_nonzero(count.sum(axis=1)) < 2:
        return cells, origin, unit, "undefined: fewer than two participants or specimens"
    if np.any(count.sum(axis=0) == 0):
        return cells, origin, unit, "undefined: a specimen has no values"
    if np.count_nonzero(count, axis=1).max() < 2:
        why = "undefined: every participant has values of one specimen only, people and specimens cannot be told apart"
        return cells, origin, unit, why
    if count.max() < 2:
        return cells, origin, unit, "undefined: no participant has two values on one specimen"
    if not within > 0:
        return cells, origin, unit, "undefined: repetitions do not differ at all"
    if np.count_nonzero(count) <= count.shape[1]:
        return cells, origin, unit, "undefined: as many fixed effects as cells"
    return cells, origin, unit, ""


def solve(cells: Cells, t1: Any, t2: Any) -> At:
    """Generalised least squares at the ratios ``t1``, ``t2``, which may be complex, and the slopes along them."""
    weight = cells.count / (1 + cells.count * t2)
    total = weight.sum(axis=1)
    shrink = t1 / (1 + t1 * total)
    information = np.diag(weight.sum(axis=0)) - (weight.T * shrink) @ weight
    right = np.sum(weight * (cells.mean - (shrink * np.sum(weight * cells.mean, axis=1))[:, None]), axis=0)
    inverse = np.linalg.inv(information)
    beta = inverse @ right
    residual = np.where(cells.count > 0, cells.mean - beta, 0.0)
    projected = weight * (residual - (shrink * np.sum(weight * residual, axis=1))[:, None])
    squares = weight**2
    squared = np.sum(squares, axis=1)
    leverage = np.sum(weight @ inverse * weight, axis=1)
    crossed = np.sum(weight @ inverse * squares, axis=1)
    of_people = np.sum(total / (1 + t1 * total) - leverage / (1 + t1 * total) ** 2)
    of_cells = np.sum(total - shrink * squared + 2 * shrink * crossed - shrink**2 * squared * leverage)
    of_cells -= np.sum(squares, axis=0) @ np.diag(inverse)
    return At(
        beta=beta,
        inverse=inverse,
        projected=projected,
        residual_squares=cells.within + np.sum(residual * projected),
        logs=np.sum(np.log(1 + cells.count * t2)) + np.sum(np.log(1 + t1 * total)) + np.linalg.slogdet(information)[1],
        residual_slopes=-np.array([np.sum(projected.sum(axis=1) ** 2), np.sum(projected**2)]),
        log_slopes=np.array([of_people, of_cells]),
    )


@dataclass(frozen=True)
class RemlFit:
    """The cells of a study in units of 2**unit relative to ``origin``, the ratios (2,) where its restricted likelihood
    is largest, the model there, and the variance of repetitions."""

    cells: Cells
    origin: float
    unit: int
    ratios: Floats
    at: At
    error: float


def fit_reml(values: ArrayLike) -> RemlFit | Outcome:
    """Fit ``values`` (P participants, S specimens, R repetitions), NaN where there is none.

    An `Outcome` without numbers, with the reason, where the study cannot bear the model: fewer than two participants
    or specimens, a specimen without values, no cell with two values, or values that do not differ within cells, or
    next to nothing beside what people differ.
    """
    cells, origin, unit, why = _cells_of(np.asarray(unmasked(values), dtype=np.float64))
    ratios = np.zeros(2) if why else best_ratios(cells)
    if ratios.max() >= LARGEST:
        why = "undefined: repetitions differ more than a million times less than participants"
    if why:
        return Outcome(method=METHOD, n=cells.n, statistic_name="F", statistic=np.nan, p=np.nan, notes=(why,))
    at = solve(cells, *ratios)
    return RemlFit(cells, origin, unit, ratios, at, float(at.residual_squares) / cells.free)


def by_ratios(cells: Cells) -> Cost:
    """Criterion of the ratios (t1, t2), the variance of repetitions at its best."""

    def cost(ratios: NDArray[Any]) -> tuple[Any, NDArray[Any]]:
        at = solve(cells, *ratios)
        return at.deviance(cells.free), at.slope(cells.free)

    return cost


def by_variances(cells: Cells) -> Cost:
    """Criterion of the variances (3,) of participants, participants by specimens, repetitions; as low as
    ``by_ratios``.
    """

    def cost(variance: NDArray[Any]) -> tuple[Any, NDArray[Any]]:
        error = np.where(variance[2].real > LEAST_ERROR, variance[2], LEAST_ERROR)
        t1, t2 = variance[:2] / error
        at, free = solve(cells, t1, t2), cells.free
        along = at.residual_slopes / error + at.log_slopes
        own = free - at.residual_squares / error - t1 * along[0] - t2 * along[1]
        value = free * np.log(error) + at.residual_squares / error - free + at.logs
        return value, np.array([*along, own]) / error

    return cost


def best_ratios(cells: Cells) -> Floats:
    """Ratios (2,), neither below 0, at which the restricted likelihood (Patterson and Thompson 1971) is largest."""
    cost = by_ratios(cells)
    start = min(((t1, t2) for t1 in _GRID for t2 in _GRID), key=lambda ratios: float(cost(np.array(ratios))[0]))
    return lowest(cost, np.array(start), np.array([True, True]), search=True)


def lowest(cost: Cost, start: Floats, moving: NDArray[np.bool_], *, search: bool = False) -> Floats:
    """Parameters (k,) at which ``cost`` is lowest, those not ``moving`` (k,) as in ``start`` (k,), none below 0.

    search : from a start that is far away; otherwise Newton's steps are tried first.
    """
    found = None if search else _newton(cost, start, moving)
    if found is not None:
        return found
    unit = np.where(start > 0, start, 1.0)  # a large ratio has a small slope, at which the search would stop

    def scaled(x: Floats) -> tuple[float, Floats]:
        value, slope = cost(x * unit)
        return float(value), np.asarray(slope) * unit

    most = LARGEST / unit
    within = [(0.0, high) if moves else (x, x) for x, moves, high in zip(start / unit, moving, most, strict=True)]
    near = optimize.minimize(scaled, start / unit, jac=True, bounds=within, method="L-BFGS-B").x * unit
    found = _newton(cost, np.asarray(near), moving)
    return np.asarray(near if found is None else found)


def _newton(cost: Cost, start: Floats, moving: NDArray[np.bool_]) -> Floats | None:
    """Newton's steps to the lowest ``cost``, for the last digits; None where they do not lead there."""
    x, last = start, np.inf
    for _ in range(_STEPS):
        slope = np.asarray(cost(x)[1])
        moves = moving & ((x > 0) | (slope < 0))
        if not moves.any():
            return x
        beside = x + 1j * TINY_STEP * np.eye(x.size)[moves]
        curvature = np.stack([cost(at)[1].imag[moves] / TINY_STEP for at in beside], axis=1)
        if not np.isfinite(curvature).all() or np.linalg.eigvalsh(curvature)[0] <= 0:
            return None
        step = np.zeros(x.size)
        try:
            step[moves] = np.linalg.solve(curvature, -slope[moves])
        except np.linalg.LinAlgError:  # a likelihood flat to the last digit
            return None
        better = np.clip(x + step, 0.0, LARGEST)
        change = float(np.max(np.abs(better - x) / np.where(x > 0, x, 1.0)))
        x = better
        if change <= _SETTLED or last <= change < _NEAR:
            return x
        last = change
    return x if last < _NEAR else None
