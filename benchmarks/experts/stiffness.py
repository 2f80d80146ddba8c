"""Stiffness from calibrations by the law 1 / kappa = a + b CASR^p: all calibrations in one call."""

from __future__ import annotations

import numpy as np
from scipy import special

Found = tuple[np.ndarray, np.ndarray, np.ndarray]
POWER = 1.5


def kappas(kappa: np.ndarray, known: np.ndarray, unknown: np.ndarray, confidence: float) -> Found:
    """kappa with interval of presses ``unknown`` (d, r), by least squares of kappa (s,) on means of ``known``
    (d, s, r): Gauss and Newton from the line of compliance, and the interval by the delta method."""
    x = known.mean(axis=2) ** POWER
    w = kappa**4  # of compliance, so that its line is near the law's least squares
    mean = x @ w / w.sum()
    z = x - mean[:, None]
    b = z @ (w / kappa) / (z * z @ w)
    a = (w / kappa).sum() / w.sum() - b * mean
    for _ in range(50):
        fitted = 1 / (a[:, None] + b[:, None] * x)
        g, left = fitted * fitted, kappa - fitted  # minus the slope in a
        gx = g * x
        aa, ab, bb = (np.einsum("ds,ds->d", one, two) for one, two in ((g, g), (g, gx), (gx, gx)))
        ra, rb = np.einsum("ds,ds->d", g, left), np.einsum("ds,ds->d", gx, left)
        det = aa * bb - ab * ab
        da, db = -(bb * ra - ab * rb) / det, -(aa * rb - ab * ra) / det
        a, b = a + da, b + db
        if np.all(np.abs(da) <= 1e-10 * np.abs(a)) and np.all(np.abs(db) <= 1e-10 * np.abs(b)):
            break
    score, dof = unknown.mean(axis=1), kappa.size - 2
    variance = np.einsum("ds,ds->d", left, left) / dof / det
    at, slope = score**POWER, POWER * b * score ** (POWER - 1)
    found = 1 / (a + b * at)
    scatter = unknown.var(axis=1, ddof=1) / unknown.shape[1]
    reach = special.stdtrit(dof, (1 + confidence) / 2) * found**2
    reach *= np.sqrt(variance * (bb - 2 * ab * at + aa * at * at) + slope**2 * scatter)
    return found, found - reach, found + reach
