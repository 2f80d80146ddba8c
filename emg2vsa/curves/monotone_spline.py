"""A curve of activity over force that only rises, or only falls, and follows no law: a monotone cubic spline in ln F.

The coefficients of its B-splines rise from each to the next by 0 or more, which is enough for the curve to rise; sums
of B-splines from one of them on are I-splines (Ramsay 1988). Its coordinate is ln F, so that it holds v = a + b ln F
exactly; its knots divide the force range evenly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.errors import DataError

DEGREE, PIECES = 3, 5
"""Degree of the polynomials, and how many of them the range of force holds: a step of 1 to 2 N is followed, noise of
a bin not.
"""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)


@dataclass(frozen=True, eq=False)
class MonotoneSpline:
    """knots : (K,) of ln(F / N), the ends repeated. coefficients : (K - 4,) in the unit of the activity."""

    knots: Floats
    coefficients: Floats

    def at(self, force_n: Floats) -> Floats:
        """Activity at forces of any shape, newtons; beyond its ends the curve keeps its last value."""
        from scipy.interpolate import BSpline  # noqa: PLC0415  (0.1 s that checks of a session do not need)

        x = np.clip(np.log(force_n), self.knots[0], self.knots[-1])
        # copies: arrays read from a file may lie at any byte, which compiled code refuses
        return np.asarray(BSpline(self.knots.copy(), self.coefficients.copy(), DEGREE)(x))

    def mean_over_steps(self, edges_n: Floats) -> Floats:
        """Mean (K,) over each step between ``edges_n`` (K + 1,), newtons, by Gauss' rule of eight points."""
        half, middle = np.diff(edges_n)[:, None] / 2, (edges_n[1:] + edges_n[:-1])[:, None] / 2
        return np.asarray(self.at(middle + half * _NODES) @ _WEIGHTS / 2)


def mean_spline(splines: list[MonotoneSpline]) -> MonotoneSpline:
    """The mean of curves with the same knots."""
    return MonotoneSpline(splines[0].knots, np.mean([each.coefficients for each in splines], axis=0))


def fit_monotone(force_n: Floats, v: Floats, weights: Floats, range_n: tuple[float, float]) -> MonotoneSpline:
    """The nearest monotone curve by least squares; of a rising and a falling one the nearer.

    force_n, v, weights : (p,) points, newtons and the unit of the activity; those that are not finite, outside
    ``range_n`` or without weight are left out. DataError below two points.
    Sums of its B-splines are I-splines (Ramsay 1988).
    """
    from scipy.interpolate import BSpline  # noqa: PLC0415
    from scipy.optimize import nnls  # noqa: PLC0415

    there = np.isfinite(force_n) & np.isfinite(v) & (weights > 0) & (force_n >= range_n[0]) & (force_n <= range_n[1])
    if np.count_nonzero(there) < 2:
        raise DataError(
            "monotone spline", wanted="two points or more", found=f"{np.count_nonzero(there)}",
            do="Give force bins of presses that can be used.",
        )  # fmt: skip
    inner = np.log(np.linspace(*range_n, PIECES + 1))
    knots = np.concatenate([np.full(DEGREE, inner[0]), inner, np.full(DEGREE, inner[-1])])
    x = np.clip(np.log(force_n[there]), inner[0], inner[-1])
    basis = BSpline.design_matrix(x, knots, DEGREE).toarray()
    steps = np.cumsum(basis[:, ::-1], axis=1)[:, ::-1]
    root = np.sqrt(weights[there] / np.max(weights[there]))
    scale = float(np.max(np.abs(v[there]))) or 1.0
    found = []
    for sign in (1.0, -1.0):
        # the first coefficient has either sign
        design = np.column_stack([steps[:, 0], -steps[:, 0], sign * steps[:, 1:]])
        parts, distance = nnls(design * root[:, None], v[there] / scale * root)
        found.append((distance, np.cumsum([parts[0] - parts[1], *(sign * parts[2:])])))
    return MonotoneSpline(knots, scale * min(found, key=lambda each: each[0])[1])
