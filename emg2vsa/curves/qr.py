"""Least squares by Householder QR with scaled columns, many at once, in the precision of its input.

Scaling makes columns of very different units harmless. LAPACK has no extended precision; this has, where the platform's
``numpy.longdouble`` is wider than a double.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Solution:
    """coefficients : (d, p). rss : (d,) residual sum of squares. root : (d, p, p), root times its transpose is the
    inverse of X'X. pivots : (d, p) diagonal of R for columns of length near 1: rounding where X has not full rank.
    """

    coefficients: NDArray[Any]
    rss: NDArray[Any]
    root: NDArray[Any]
    pivots: NDArray[Any]


def solve(x: NDArray[Any], y: NDArray[Any]) -> Solution:
    """Least squares of y (d, n) on the columns of x (d, n, p), n >= p >= 1, both of one floating type."""
    p = x.shape[2]
    # powers of two: scaling must not round the columns
    exponent = np.frexp(np.max(np.abs(x), axis=1, initial=0))[1] + np.frexp(np.sqrt(x.shape[1]))[1]
    work = np.concatenate([np.ldexp(x, -exponent[:, None, :]), y[:, :, None]], axis=2)
    for j in range(p):
        _reflect(work, j)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        root = np.ldexp(_inverse_upper(work[:, :p, :p]), -exponent[:, :, None])
        coefficients = np.sum(root * work[:, None, :p, p], axis=2)
    return Solution(
        coefficients=coefficients,
        rss=np.sum(work[:, p:, p] ** 2, axis=1),
        root=root,
        pivots=np.abs(np.diagonal(work[:, :p, :p], axis1=1, axis2=2)),
    )


def _reflect(work: NDArray[Any], j: int) -> None:
    """Make column j zero below the diagonal, in place."""
    v = work[:, j:, j].copy()
    length = np.sqrt(np.sum(v * v, axis=1))
    v[:, 0] += np.where(v[:, 0] < 0, -length, length)
    norm = np.sum(v * v, axis=1)
    factor = 2 * np.sum(v[:, :, None] * work[:, j:, j:], axis=1) / np.where(norm > 0, norm, 1)[:, None]
    work[:, j:, j:] -= v[:, :, None] * factor[:, None, :]


def _inverse_upper(r: NDArray[Any]) -> NDArray[Any]:
    """Inverse of upper triangular matrices (d, p, p), by rows from the last; not finite at a zero on the diagonal."""
    p = r.shape[1]
    inverse = np.zeros_like(r)
    for i in reversed(range(p)):
        inverse[:, i] = -np.sum(r[:, i, i + 1 :, None] * inverse[:, i + 1 :], axis=1)
        inverse[:, i, i] += 1
        inverse[:, i] /= r[:, i, i, None]
    return inverse
