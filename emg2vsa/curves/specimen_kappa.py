"""kappa of a specimen and its error: presses of one mounting are no witnesses of another, and one casting none of its
recipe.

Means of means: presses of a mounting, mountings of a casting, castings. The variance at each step is that of all there
are, averaged with a stated one by their degrees of freedom (Smyth 2004, Statistical Applications in Genetics and
Molecular Biology 3, 3); with one of a kind the stated one stands alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.curves.force_range import t_975

LEVELS = ("presses", "mountings", "castings")


@dataclass(frozen=True)
class Spread:
    """Stated standard deviations as shares: between presses of one mounting, mountings, and castings of one recipe.

    Presses and castings: of silicone (Dawood et al. 2026, CC BY 4.0): five presses of one casting scatter by 1.0 %
    (typical of ten mixtures), two castings differ by 3.3 % (median of 19). Mountings: a guess, as for the emulated rig.
    """

    presses: float = 0.01
    mountings: float = 0.02
    castings: float = 0.035


_WORTH = {"presses": 2.5, "mountings": 6.0, "castings": 6.0}
"""Degrees of freedom of the stated ones: how unlike those of the ten mixtures are, for presses (Smyth's moments); else
as many as leave 2 of 19 differences of castings outside (a guess)."""


@dataclass(frozen=True, eq=False)
class NestedMean:
    """mean : of the castings. error, dof (3,) : of that mean over presses, mountings and castings, each with those
    before it. count (3,) : of each there is. steps : SD between them (3,), as it entered, in the unit of the mean."""

    mean: float
    error: Floats
    dof: Floats
    count: tuple[int, int, int]
    steps: Floats

    def half(self, level: str = LEVELS[-1]) -> float:
        """Half the width of the 95 % interval that holds for further ones of that level."""
        at = LEVELS.index(level)
        return t_975(float(self.dof[at])) * float(self.error[at])


def nested_mean(
    values: Floats, errors: Floats, castings: Sequence[str], mountings: Sequence[str], spread: Spread | None = None
) -> NestedMean:
    """Mean of means, with the variance of each step averaged with a stated one (Smyth 2004).

    values, errors : (n,) of presses, with the standard error within each.
    castings, mountings : (n,) what it was; a mounting is one of its casting. NaN without values.
    Why over mountings and castings: decision 50.
    """
    spread = spread or Spread()
    if not values.size:
        nothing = np.full(3, np.nan)
        return NestedMean(np.nan, nothing, nothing, (0, 0, 0), nothing)
    # of presses, then mountings, then castings: means, groups they are in, and the variance each has from below
    groups: list[tuple[str, ...]] = list(zip(castings, mountings, strict=True))
    means, from_below, found, below_dof = values, errors**2, [], np.inf
    for level in LEVELS:
        names = list(dict.fromkeys(groups))
        at = np.array([names.index(group) for group in groups])
        n = np.bincount(at)
        centre = np.bincount(at, means) / n
        own = (getattr(spread, level) * abs(float(values.mean()))) ** 2
        left, seen, below = means - centre[at], means.size - n.size, float(np.mean(from_below))
        prior = own + below
        known = prior**2 / (own**2 / _WORTH[level] + below**2 / below_dof) if prior > 0 else _WORTH[level]
        step = max((known * prior + float(left @ left)) / (known + seen) - below, 0.0)
        from_below = np.bincount(at, from_below + step) / n**2
        found.append((_of_all(from_below, names), known + seen, step, means.size))
        means, groups, below_dof = centre, [name[:-1] for name in names], known + seen
    variance, dof, steps, count = zip(*found, strict=True)
    return NestedMean(float(means[0]), np.sqrt(variance), np.array(dof), count, np.sqrt(steps))


def _of_all(variance: Floats, groups: Sequence[tuple[str, ...]]) -> float:
    """Variance of the mean of means of means, from that of each group."""
    while groups[0]:
        names = list(dict.fromkeys(group[:-1] for group in groups))
        at = np.array([names.index(group[:-1]) for group in groups])
        variance, groups = np.bincount(at, variance) / np.bincount(at) ** 2, names
    return float(variance[0])
