"""Is the mean of vectors zero, and how long is it? Hotelling's T squared, and the interval of the length.

The vectors of a group scatter about the mean of their group; all groups have one covariance, pooled. What is tested is
the mean of the group means, each the same. The interval of its length is that of the shortest and the longest vector
in the confidence ellipsoid of the mean (Scheffe): it reaches 0 where T squared does not reject.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats, Ints

_BESIDE = 1e-7
"Share of a standard error that does not matter."
_HALVINGS = 60


@dataclass(frozen=True, eq=False)
class MeanVector:
    """mean (d,) of the group means, of ``vectors`` in ``groups``. covariance (d, d) of the mean, ``dof`` behind it.

    p : of a mean of zero; NaN where there are too few vectors, or they scatter in fewer directions than d.
    """

    mean: Floats
    covariance: Floats
    dof: int
    p: float

    @property
    def length(self) -> float:
        """Length of the mean, which noise makes longer."""
        return float(np.linalg.norm(self.mean))

    def interval(self, confidence: float) -> tuple[float, float]:
        """Interval of the length; NaN where ``p`` is."""
        if self.p != self.p:
            return np.nan, np.nan
        d, free = self.mean.size, self.dof - self.mean.size + 1
        reach = d * self.dof / free * float(special.fdtri(d, free, confidence))
        variances, axes = np.linalg.eigh(self.covariance)
        return _lengths(axes.T @ self.mean, variances, reach)


def mean_vector(vectors: Floats, groups: Ints) -> MeanVector:
    """Mean of ``vectors`` (n, d), finite; groups (n,) : number of the group of each, 0 to G - 1, none of them empty.

    The test is Hotelling's T squared (1931).
    """
    n, d = vectors.shape
    count = np.bincount(groups)
    means = np.stack([np.bincount(groups, column) / count for column in vectors.T], axis=1)
    mean, dof = np.mean(means, axis=0), n - count.size
    rest = vectors - means[groups]
    shares = np.sum(1 / count) / count.size**2
    covariance = rest.T @ rest / max(dof, 1) * shares
    if dof < d or not _whole(covariance):
        return MeanVector(mean, covariance, dof, np.nan)
    free = dof - d + 1
    t2 = float(mean @ np.linalg.solve(covariance, mean))
    return MeanVector(mean, covariance, dof, float(special.fdtrc(d, free, t2 * free / (d * dof))))


def _whole(covariance: Floats) -> bool:
    spread = np.sqrt(np.diag(covariance))
    if not np.all(spread > 0):
        return False
    return bool(np.linalg.eigvalsh(covariance / np.outer(spread, spread))[0] > covariance.shape[0] * 1e-12)


def _lengths(centre: Floats, variances: Floats, reach: float) -> tuple[float, float]:
    """Shortest and longest vector of the ellipsoid sum (x - centre)^2 / variances <= reach, by Lagrange multipliers."""
    unit = float(np.sqrt(variances[-1]))
    centre, variances = centre / unit, variances / variances[-1]
    # exactly in the middle of the widest axis there would be two longest vectors
    centre[-1] = np.copysign(max(abs(centre[-1]), _BESIDE), centre[-1])

    def beyond(multiplier: float) -> float:
        return float(np.sum(variances * centre**2 / (variances + multiplier) ** 2)) - reach

    def at(multiplier: float) -> float:
        return unit * float(np.linalg.norm(multiplier * centre / (variances + multiplier)))

    far = 1.01 * float(np.linalg.norm(centre)) / np.sqrt(reach)
    low = at(_root(beyond, 0.0, far)) if beyond(0.0) > 0 else 0.0
    return low, at(-1 - _root(lambda past: beyond(-1 - past), _BESIDE**2, far))


def _root(falling: Callable[[float], float], above: float, below: float) -> float:
    """Where the function is 0, between a place where it is above and one where it is below."""
    for _ in range(_HALVINGS):
        middle = (above + below) / 2
        above, below = (middle, below) if falling(middle) > 0 else (above, middle)
    return (above + below) / 2
