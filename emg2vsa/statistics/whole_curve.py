"""Curves of the same people on several specimens, compared at every force with one error rate for all forces.

At each force: F of the repeated-measures analysis, and paired t of every pair of specimens. The largest of them over
the forces (and pairs) is compared with its distribution under random rotations of the people (Langsrud 2005). Where
specimens do not differ, the differences within people are rows of a Gaussian matrix of mean zero, and no rotation of
rows changes its law, whatever the covariance over forces and specimens. That is exact for five people too, whose 16
patterns of signs cannot reach .05. A rotation sends the mean of all rows along a random direction w of length 1; F and
t follow from w'Y alone.

Bands come from rotated residuals, as a mean that is not zero would make all forces look alike. A pair has to pass both
thresholds, so the band of its difference excludes zero where the pair differs. Ranges of neighbouring forces beyond the
threshold are taken together, as statistical parametric mapping does (Pataky 2010).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from emg2vsa.arrays import Floats, Ints, exponent_of, runs_of
from emg2vsa.errors import DataError
from emg2vsa.statistics.moments import finite_or_nan, without_rounding
from emg2vsa.statistics.repeated import rm_anova

DRAWS, SEED = 9_999, 2005
"""Random directions beside the observed one, and the seed of numpy's default generator that draws them."""
FEWEST, FEWEST_FOR_BANDS = 3, 4
"""People. The residuals of three span a plane: bands would be too narrow."""
_AT_ONCE = 4_000_000
"""Numbers that are in memory at once."""
_Z = 1.96


@dataclass(frozen=True)
class Threshold:
    """What the largest statistic exceeds with a chance of alpha; low, high : 95 % Monte-Carlo interval."""

    value: float = np.nan
    low: float = np.nan
    high: float = np.nan


@dataclass(frozen=True)
class Cluster:
    """Neighbouring forces ``start`` to ``stop`` (excluded) beyond the threshold; the largest F or |t| is at ``at``.

    pair : its number, -1 for all specimens together. p : chance of a statistic as large at any force (of any pair).
    """

    pair: int
    start: int
    stop: int
    at: int
    largest: float
    p: float


@dataclass(frozen=True, eq=False)
class CurveTests:
    """Q pairs of S specimens, pressed by P people, at G forces.

    people, specimens, forces : numbers of those that were compared; none where ``why`` says why nothing was. mean (S,
    G) : of the people; half_width (S, G) : of its band, which is about the difference from the mean of all specimens.
    f, p (G,) : p of the largest F. first, second (Q,) : places of a pair in ``specimens``. difference, its half_width,
    t, p (Q, G), ``pair_...`` : of first less second. Thresholds : of f, and of |t|. Half widths are NaN for fewer
    people than ``FEWEST_FOR_BANDS``; f and t are infinite where all people differ by the same amounts, NaN by nothing.
    """

    people: Ints
    specimens: Ints
    forces: Ints
    why: str
    mean: Floats
    half_width: Floats
    f: Floats
    p: Floats
    first: Ints
    second: Ints
    pair_difference: Floats
    pair_half_width: Floats
    pair_t: Floats
    pair_p: Floats
    f_threshold: Threshold
    t_threshold: Threshold
    alpha: float
    draws: int

    def clusters(self) -> list[Cluster]:
        """Ranges of all specimens, then of every pair; a range ends where the difference changes its sign."""
        found = list(self._ranges(-1, self.f, self.p, np.ones(self.f.shape)))
        for pair, (t, p) in enumerate(zip(self.pair_t, self.pair_p, strict=True)):
            both = [each for sign in (1, -1) for each in self._ranges(pair, np.abs(t), p, sign * t)]
            found += sorted(both, key=lambda cluster: cluster.start)
        return found

    def _ranges(self, pair: int, size: Floats, p: Floats, sign: Floats) -> Iterator[Cluster]:
        beyond = self.forces[(p <= self.alpha) & (sign > 0)]
        starts, stops = runs_of(np.isin(np.arange(self.forces.max(initial=-1) + 1), beyond))
        for start, stop in zip(starts.tolist(), stops.tolist(), strict=True):
            own = slice(*np.searchsorted(self.forces, (start, stop)))
            at = own.start + int(np.argmax(size[own]))
            yield Cluster(pair, start, stop, int(self.forces[at]), float(size[at]), float(p[at]))


def curve_tests(values: ArrayLike, alpha: float = 0.05, draws: int = DRAWS, seed: int = SEED) -> CurveTests:
    """Compare ``values`` (P, S, G), NaN where there is none. DataError for another shape; never for a small table.

    Left out are specimens that fewer than half of the people have; then, until nothing lacks, the person or the force
    that lacks the largest share of the others.
    Why rotations (Langsrud 2005): decision 44.
    """
    y = finite_or_nan(np.asarray(values, dtype=np.float64))
    if y.ndim != 3:
        do = "Give the curves of a person as one table, a row a specimen."
        raise DataError("curves", wanted="numbers of shape (people, specimens, forces)", found=f"{y.shape}", do=do)
    people, specimens, forces, why = _whole_table(np.isfinite(y))
    y = y[np.ix_(people, specimens, forces)]
    unit = int(exponent_of(y.ravel())[0])
    y = np.ldexp(y, -unit)
    first, second = np.triu_indices(specimens.size, 1)
    own = y - _mean(y, 1)[:, None]
    f = rm_anova(y.transpose(2, 0, 1)).f if y.size else np.empty(0)
    difference, error = _with_error(y[:, first] - y[:, second])
    with np.errstate(divide="ignore", invalid="ignore"):
        t = difference / error
    of_all, of_pairs, _ = _nulls(own, draws, seed)
    t2_threshold, pair_p = of_pairs.threshold(alpha), of_pairs.p(t**2)
    half_width = pair_half_width = np.nan
    if people.size >= FEWEST_FOR_BANDS:
        _, of_residuals, of_own = _nulls(own - _mean(own, 0), draws, seed)
        t2_threshold = max(t2_threshold, of_residuals.threshold(alpha), key=_value)
        pair_p = np.maximum(pair_p, of_residuals.p(t**2))
        half_width, pair_half_width = np.sqrt((of_own.threshold(alpha).value, t2_threshold.value))
    return CurveTests(
        people, specimens, forces, why,
        mean=np.ldexp(_mean(y, 0), unit),
        half_width=np.ldexp(_with_error(own)[1] * half_width, unit),
        f=f,
        p=of_all.p(f),
        first=first,
        second=second,
        pair_difference=np.ldexp(difference, unit),
        pair_half_width=np.ldexp(error * pair_half_width, unit),
        pair_t=t,
        pair_p=pair_p,
        f_threshold=of_all.threshold(alpha),
        t_threshold=Threshold(*np.sqrt((t2_threshold.value, t2_threshold.low, t2_threshold.high)).tolist()),
        alpha=alpha,
        draws=draws,
    )  # fmt: skip


def _value(threshold: Threshold) -> float:
    return threshold.value


def _whole_table(known: NDArray[np.bool_]) -> tuple[Ints, Ints, Ints, str]:
    """Numbers of the people, specimens and forces of a table without gaps, and why there is none."""
    had = np.any(known, axis=2)
    specimens = np.flatnonzero(np.any(had, axis=0) & (2 * had.sum(axis=0) >= np.any(had, axis=1).sum()))
    takes, nothing = "the test takes {} with curves of {}, and found {}", np.empty(0, dtype=np.int64)
    if specimens.size < 2:
        said = takes.format("2 specimens", "half of the people or more", specimens.size)
        return nothing, nothing, nothing, said
    there = np.all(known[:, specimens], axis=1)
    people, forces = (np.ones(size, dtype=np.bool_) for size in there.shape)
    while (lacks := ~there & people[:, None] & forces).any():
        by_person = lacks.sum(axis=1) / np.count_nonzero(forces)
        by_force = lacks.sum(axis=0) / np.count_nonzero(people)
        worst, shares = (people, by_person) if by_person.max() >= by_force.max() else (forces, by_force)
        worst[np.argmax(shares)] = False
    if (n := np.count_nonzero(people)) < FEWEST or not forces.any():
        return nothing, nothing, nothing, takes.format(f"{FEWEST} people", "every specimen", n)
    return np.flatnonzero(people), specimens, np.flatnonzero(forces), ""


def _mean(values: Floats, axis: int) -> Floats:
    """NaN where there is nothing."""
    return np.asarray(values.sum(axis=axis) / (values.shape[axis] or np.nan))


def _with_error(values: Floats) -> tuple[Floats, Floats]:
    """Mean over people of ``values`` (P, ...), which differ by less than 2, and its standard error; 0 for rounding."""
    n, mean = len(values), _mean(values, 0)
    kept, squares = (without_rounding(each, n, 1.0) for each in (n * mean**2, np.sum((values - mean) ** 2, axis=0)))
    return np.where(kept > 0, mean, 0.0), np.sqrt(squares / max(n * (n - 1), 1))


@dataclass(frozen=True)
class _Null:
    """shares : (B,) of each random direction, largest share of the squares that lies along it; ascending.

    F, or t squared, is ``people`` - 1 times this share over the rest.
    """

    shares: Floats
    people: int

    def threshold(self, alpha: float) -> Threshold:
        """Threshold of F; infinite where ``alpha`` is less than one of all directions."""
        if not self.shares.size:
            return Threshold()
        rank = alpha * (self.shares.size + 1)
        off = _Z * np.sqrt(rank * (1 - alpha))
        return Threshold(*(self._largest(int(each + 1e-9)) for each in (rank, rank + off, rank - off)))

    def _largest(self, rank: int) -> float:
        share = float(self.shares[-min(rank, self.shares.size)]) if rank > 0 else 1.0
        return (self.people - 1) * share / (1 - share) if share < 1 else np.inf

    def p(self, f: Floats) -> Floats:
        """Share of all directions, the observed one included, whose largest F is ``f`` or more."""
        with np.errstate(divide="ignore"):
            share = 1 / (1 + (self.people - 1) / f)
        fewer = np.searchsorted(self.shares, share * (1 - 1e-12))
        return np.where(np.isnan(f), np.nan, (1 + self.shares.size - fewer) / (1 + self.shares.size))


def _nulls(own: Floats, draws: int, seed: int) -> tuple[_Null, _Null, _Null]:
    """Statistics of all specimens, of pairs, and of each specimen, from ``own`` (P, S, G), values less the mean of
    the person.

    People are taken by the size of their rows, so that their order does not matter.
    """
    n, k, forces = own.shape
    first, second = np.triu_indices(k, 1)
    own = own[np.argsort(np.sum(own**2, axis=(1, 2)), kind="stable")]
    each, pairs = np.sum(own**2, axis=0), np.sum((own[:, first] - own[:, second]) ** 2, axis=0)
    totals = (without_rounding(squares, n * k, 1.0) for squares in (each.sum(axis=0), pairs, each))
    weights = [1 / np.where(total > 0, total, np.inf) for total in totals]
    shares = np.empty((3, draws if own.size else 0))
    rng, step = np.random.default_rng(seed), max(1, _AT_ONCE // max(first.size * forces, n, 1))
    for start in range(0, shares.shape[1], step):
        some = slice(start, min(start + step, draws))
        w = rng.standard_normal((some.stop - start, n))
        w /= np.linalg.norm(w, axis=1, keepdims=True)
        z = (w @ own.reshape(n, -1)).reshape(-1, k, forces)
        held = z**2
        shares[0, some] = np.max(np.sum(held, axis=1) * weights[0], axis=1)
        shares[1, some] = np.max((z[:, first] - z[:, second]) ** 2 * weights[1], axis=(1, 2))
        shares[2, some] = np.max(held * weights[2], axis=(1, 2))
    of_all, of_pairs, of_each = np.sort(shares, axis=1)
    return _Null(of_all, n), _Null(of_pairs, n), _Null(of_each, n)
