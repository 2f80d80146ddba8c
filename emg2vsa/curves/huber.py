"""Huber's robust straight line, many at once: bursts and artefacts count for less."""

from __future__ import annotations

import dataclasses

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.curves.line import Line, fit_line

TUNING = 1.345
"""95 % of least squares' efficiency under normal errors (Huber 1981)."""
_MAD_OF_NORMAL = 0.6744897501960817
_MAX_ITERATIONS = 100
_TOLERANCE = 1e-10


def fit_line_huber(x: Floats, y: Floats, weights: Floats) -> Line:
    """Iteratively reweighted least squares, scale from the median absolute residual.

    Shapes as in ``fit_line``. Standard errors are Huber's H1 (Huber and Ronchetti 2009, 7.6), as in R's MASS::rlm
    and statsmodels' RLM; R^2 is that of the final weighted fit.
    """
    used = weights > 0
    root = np.sqrt(weights)
    line = fit_line(x, y, weights)
    huber = np.ones_like(y)
    scaled = np.zeros_like(y)
    for _ in range(_MAX_ITERATIONS):
        scaled = _scaled_residuals(line, x, y, root, used)
        with np.errstate(divide="ignore"):
            renewed = np.minimum(1.0, TUNING / np.abs(scaled))
        change = np.max(np.abs(renewed - huber), initial=0.0)
        huber = renewed
        line = fit_line(x, y, weights * huber)
        if change < _TOLERANCE:
            break
    return _with_h1_errors(line, x, y, root, used)


def _scaled_residuals(line: Line, x: Floats, y: Floats, root: Floats, used: np.ndarray) -> Floats:
    residual = _residuals(line, x, y, root)
    return residual / _scale(residual, y, used)


def _residuals(line: Line, x: Floats, y: Floats, root: Floats) -> Floats:
    intercept, slope = np.nan_to_num(line.intercept), np.nan_to_num(line.slope)
    return root * (y - (intercept[:, None] + slope[:, None] * x))


def _scale(residual: Floats, y: Floats, used: np.ndarray) -> Floats:
    """Median absolute residual over its value for the standard normal, (k, 1); never below the rounding of y."""
    n = np.count_nonzero(used, axis=1, keepdims=True)
    ordered = np.sort(np.where(used, np.abs(residual), np.inf), axis=1)
    low = np.take_along_axis(ordered, np.maximum((n - 1) // 2, 0), axis=1)
    high = np.take_along_axis(ordered, np.minimum(n // 2, y.shape[1] - 1), axis=1)
    rounding = 4 * np.finfo(np.float64).eps * np.max(np.abs(y), axis=1, keepdims=True, initial=0.0, where=used)
    floor = np.maximum(rounding, np.finfo(np.float64).tiny)
    return np.asarray(np.maximum(np.where(n > 0, 0.5 * low + 0.5 * high, 0.0) / _MAD_OF_NORMAL, floor))


def _with_h1_errors(line: Line, x: Floats, y: Floats, root: Floats, used: np.ndarray) -> Line:
    """``line`` with the H1 standard errors, which rest on the design of the points, not on the final weights."""
    residual = _residuals(line, x, y, root)
    scale = _scale(residual, y, used)
    scaled = residual / scale
    n = line.n.astype(np.float64)
    inside = used & (np.abs(scaled) <= TUNING)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.count_nonzero(inside, axis=1) / n  # mean of psi'
        correction = 1 + 2 / n * (1 - share) / share
        psi2 = np.sum(np.clip(scaled, -TUNING, TUNING) ** 2, axis=1, where=used)
        s = correction * scale[:, 0] * np.sqrt(psi2 / np.where(line.dof > 0, line.dof, np.nan)) / share
        w = root * root
        total = np.sum(w, axis=1)
        centre = np.sum(w * x, axis=1) / total
        sxx = np.sum(w * (x - centre[:, None]) ** 2, axis=1)
        intercept_se = s * np.sqrt(1 / total + centre**2 / sxx) + 0 * line.slope
        slope_se = s / np.sqrt(sxx) + 0 * line.slope
    return dataclasses.replace(line, intercept_se=intercept_se, slope_se=slope_se)
