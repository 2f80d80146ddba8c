"""Exponential calibration from CASR to stiffness, kappa = p exp(q CASR), and its error on a specimen it never saw."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]
STEPS = 50
HALVINGS = 30
SMALLEST_GAIN = 1e-12


@dataclass(frozen=True)
class Calibration:
    """kappa = exp(log_p + q CASR), kappa in N/mm and q in the inverse unit of CASR (paper, section VI)."""

    log_p: float
    q: float

    def kappa_n_mm(self, casr: NDArray[Any] | float) -> Values:
        """Stiffness of a specimen with this CASR, N/mm."""
        return np.asarray(np.exp(self.log_p + self.q * np.asarray(casr, dtype=np.float64)))


def calibrated(casr: NDArray[Any], kappa_n_mm: NDArray[Any]) -> Calibration:
    """Least squares in kappa, by Gauss-Newton from the straight line through ln kappa.

    Scores are centred and scaled for the arithmetic, so that their unit does not matter. CASR that is the same for
    every press, or unknown for one, says nothing about stiffness: both numbers are NaN.
    """
    casr = np.asarray(casr, dtype=np.float64)
    centre, spread = casr.mean(), casr.std()
    if not spread > 0:
        return Calibration(float("nan"), float("nan"))
    x = (casr - centre) / spread
    design = np.column_stack([np.ones_like(x), x])
    beta = np.linalg.lstsq(design, np.log(kappa_n_mm), rcond=None)[0]
    for _ in range(STEPS):
        step, before = _gauss_newton_step(design, beta, kappa_n_mm), _cost(design, beta, kappa_n_mm)
        for _ in range(HALVINGS):
            if _cost(design, beta + step, kappa_n_mm) <= before:
                break
            step = step / 2
        beta = beta + step
        if before - _cost(design, beta, kappa_n_mm) <= SMALLEST_GAIN * before:
            break
    return Calibration(float(beta[0] - beta[1] * centre / spread), float(beta[1] / spread))


def _gauss_newton_step(design: Values, beta: Values, kappa: NDArray[Any]) -> Values:
    curve = np.exp(design @ beta)
    return np.asarray(np.linalg.lstsq(design * curve[:, None], kappa - curve, rcond=None)[0])


def _cost(design: Values, beta: Values, kappa: NDArray[Any]) -> float:
    with np.errstate(over="ignore"):
        return float(np.sum((kappa - np.exp(design @ beta)) ** 2))


def unknown_error_percent(casr: NDArray[Any], kappa_n_mm: Values, unknown: float) -> float:
    """Error on the stiffness of one specimen, from the others' calibration at the mean CASR of its presses, percent.

    casr : (n_specimens, n_repetitions), one angle. kappa_n_mm : (n_specimens,). unknown : one of these stiffnesses.
    """
    hidden = kappa_n_mm == unknown
    known = np.repeat(kappa_n_mm[~hidden], casr.shape[1])
    found = calibrated(casr[~hidden].ravel(), known).kappa_n_mm(casr[hidden].mean())
    return float(100 * (found / unknown - 1))
