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
        groups.setdefault(casting, {}).setdefault(mounting, []).append(_Mean(value, (_Part(error**2),)))
    by_mounting = [[_over(own, stated, 0) for own in casting.values()] for casting in groups.values()]
    whole = _over([_over(own, stated, 1) for own in by_mounting], stated, 2)
    error, dof, step = np.array([(part.variance, part.known + part.seen, part.step) for part in whole.parts[1:]]).T
    count = (values.size, sum(map(len, by_mounting)), len(by_mounting))
    return NestedMean(whole.value, np.sqrt(error), dof, count, np.sqrt(step))


@dataclass(frozen=True)
class _Part:
    """Variance of a mean; degrees of freedom of what was known of it before, and seen; variance of one step."""

    variance: float
    known: float = np.inf
    seen: int = 0
    step: float = 0.0


@dataclass(frozen=True)
class _Mean:
    """parts : within a press, over presses, mountings and castings, as far as it goes."""

    value: float
    parts: tuple[_Part, ...]


def _over(means: Sequence[_Mean], stated: dict[str, float], level: int) -> _Mean:
    """Mean over those that scatter; what is known of lower levels averages over them."""
    n, own, worth = len(means), stated[LEVELS[level]], _WORTH[LEVELS[level]]
    lower = [
        _Part(
            float(np.mean([part.variance for part in parts])) / n, max(part.known for part in parts),
            sum(part.seen for part in parts), float(np.mean([part.step for part in parts])),
        )
        for parts in zip(*(mean.parts for mean in means), strict=True)
    ]  # fmt: skip
    below = lower[-1].variance * n
    prior = own + below
    known = prior**2 / (own**2 / worth + below**2 / (lower[-1].known + lower[-1].seen)) if prior > 0 else worth
    values = [mean.value for mean in means]
    between = float(np.var(values, ddof=1)) if n > 1 else 0.0
    moderated = (known * prior + (n - 1) * between) / (known + n - 1)
    return _Mean(float(np.mean(values)), (*lower, _Part(moderated / n, known, n - 1, max(moderated - below, 0.0))))
