"""The laws of activity over force by the error of a force bin that they did not see, for hundreds of studies.

``emg2vsa.companions.force_laws`` fits each law again without each bin. Here the residual of a bin that is left out is
that of the whole fit over 1 - h, its leverage: exact for logarithm and line, of first order for the power law, which
differs by less than half a percent (tests/benchmarks/test_claims.py).
"""

from __future__ import annotations

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.companions.force_laws import ForceLaws
from emg2vsa.fits import Fits

_STEPS = 8
"Of Gauss and Newton: the last one moves no digit that counts."


def laws_of(fits: Fits, presses: int) -> ForceLaws:
    """Of whole cells of so many presses, one after the other; errors of presses that were left out are NaN."""
    f, v = fits.bin_force_n, fits.bin_v
    left_out = np.stack([_straight(np.log(f), v), _power(np.log(f), v), _straight(f, v)])
    cells = left_out.reshape(3, -1, presses * f.shape[1])
    level = np.abs(v.reshape(cells.shape[1:]).mean(axis=1))
    by_bin = np.sqrt(np.mean(cells**2, axis=2)) / level
    nothing, none = np.full((2, 3), np.nan), np.zeros((2, 3), dtype=np.int64)
    return ForceLaws(
        participant=fits.participant[::presses], specimen=fits.specimen[::presses],
        error=np.stack([np.full(by_bin.shape, np.nan), by_bin]), ratio=nothing, ratio_low=nothing, ratio_high=nothing,
        p=nothing, better=none, compared=none[:, 0],
    )  # fmt: skip


def _straight(x: Floats, v: Floats) -> Floats:
    """Residuals (n, B) of bins that a straight line in x did not see."""
    dx, dv = (values - values.mean(axis=1, keepdims=True) for values in (x, v))
    squares = np.sum(dx**2, axis=1, keepdims=True)
    rest = dv - np.sum(dx * dv, axis=1, keepdims=True) / squares * dx
    return np.asarray(rest / (1 - 1 / x.shape[1] - dx**2 / squares))


def _power(x: Floats, v: Floats) -> Floats:
    """The same of v = exp(a + q x), by least squares of v."""
    dx = x - x.mean(axis=1, keepdims=True)
    level = v.mean(axis=1, keepdims=True)
    q = np.sum(dx * v, axis=1, keepdims=True) / np.sum(dx**2, axis=1, keepdims=True) / level
    for _ in range(_STEPS):
        shape = np.exp(q * dx)
        one, other = shape, level * dx * shape
        aa, ab, bb = (np.sum(p * r, axis=1, keepdims=True) for p, r in ((one, one), (one, other), (other, other)))
        rest = v - level * shape
        ra, rb, det = (*(np.sum(p * rest, axis=1, keepdims=True) for p in (one, other)), aa * bb - ab**2)
        level, q = level + (bb * ra - ab * rb) / det, q + (aa * rb - ab * ra) / det
    return np.asarray(rest / (1 - (bb * one**2 - 2 * ab * one * other + aa * other**2) / det))
