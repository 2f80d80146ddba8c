"""kappa of a specimen and its error: presses of one mounting are no witnesses of another, and one casting none of its
recipe.

Means of means: presses of a mounting, mountings of a casting, castings. The variance at each step is that of what is
there, averaged with a stated one by their degrees of freedom (Smyth 2004, Statistical Applications in Genetics and
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
    """values, errors : (n,) of presses, with the standard error within each. castings, mountings : (n,) what it was;
    a mounting is one of its casting. NaN without values."""
    spread = spread or Spread()
    if not values.size:
        nothing = np.full(3, np.nan)
        return NestedMean(np.nan, nothing, nothing, (0, 0, 0), nothing)
    stated = {level: (getattr(spread, level) * abs(float(values.mean()))) ** 2 for level in LEVELS}
    groups: dict[str, dict[str, list[_Mean]]] = {}
    for value, error, casting, mounting in zip(values.tolist(), errors.tolist(), castings, mountings, strict=True):
        groups.setdefault(casting, {}).setdefault(mounting, []).append(_Mean((value,), (error**2,), (np.inf,), (0.0,)))
    by_mounting = [[_over(own, stated, 0) for own in casting.values()] for casting in groups.values()]
    whole = _over([_over(own, stated, 1) for own in by_mounting], stated, 2)
    count = (values.size, sum(map(len, by_mounting)), len(by_mounting))
    # over presses alone, mountings and castings are these: their errors average, whatever the scatter between them
    return NestedMean(
        whole.value[-1], np.sqrt(whole.variance[1:]), np.array(whole.dof[1:]), count, np.sqrt(whole.step[1:])
    )


@dataclass(frozen=True)
class _Mean:
    """value, variance of the mean, degrees of freedom, and variance between its parts: at each level so far."""

    value: tuple[float, ...]
    variance: tuple[float, ...]
    dof: tuple[float, ...]
    step: tuple[float, ...]


def _over(parts: Sequence[_Mean], stated: dict[str, float], level: int) -> _Mean:
    """Mean over parts that scatter; what is known of lower levels averages over them."""
    n, known, worth = len(parts), stated[LEVELS[level]], _WORTH[LEVELS[level]]
    values = np.array([part.value[-1] for part in parts])
    variance = np.mean([part.variance for part in parts], axis=0)
    dof = np.mean([np.minimum(part.dof, 1e9) for part in parts], axis=0) * n
    below = float(variance[-1])
    prior = known + below
    prior_dof = prior**2 / (known**2 / worth + below**2 / float(dof[-1])) if prior > 0 else worth
    between = float(np.var(values, ddof=1)) if n > 1 else 0.0
    moderated = (prior_dof * prior + (n - 1) * between) / (prior_dof + n - 1)
    return _Mean(
        (*parts[0].value, float(values.mean())), (*(variance / n), moderated / n),
        (*dof, prior_dof + n - 1), (*np.mean([part.step for part in parts], axis=0), max(moderated - below, 0.0)),
    )  # fmt: skip
