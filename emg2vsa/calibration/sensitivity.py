"""How far an estimate moves with every number that went into it, by refitting beside it; any law, any way to fit."""

from __future__ import annotations

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.calibration.calibrate import Calibration, fitted_points
from emg2vsa.calibration.laws import fit_law

_SHARE = 1e-5  # of a score or a stiffness; central differences are then good to ten digits


def by_mean_score(calibration: Calibration, casr: Floats) -> Floats:
    """d eta / d mean score (d, S): of the estimate at score ``casr`` (d,), for the presses of each known specimen."""
    step = _SHARE * np.abs(calibration.mean_casr)
    return _difference(calibration, casr, step, np.zeros_like(step)) / step


def by_kappa(calibration: Calibration, casr: Floats) -> Floats:
    """d eta / d kappa (d, S): of the estimate at score ``casr`` (d,), for each known stiffness."""
    step = _SHARE * calibration.kappa
    return _difference(calibration, casr, np.zeros_like(step), step) / step


def _difference(calibration: Calibration, casr: Floats, score_step: Floats, kappa_step: Floats) -> Floats:
    """Half of the change of eta (d, S) between one specimen's score and kappa moved up and both moved down."""
    d, s, r = calibration.casr.shape
    one = np.eye(s)
    eta = []
    for sign in (0.5, -0.5):
        moved = calibration.casr[:, None] + (2 * sign * one * score_step[:, None])[..., None]
        known = calibration.kappa[:, None] + 2 * sign * one * kappa_step[:, None]
        x, y = fitted_points(moved.reshape(d * s, s, r), known.reshape(d * s, s), calibration.settings.points)
        fit = fit_law(calibration.settings.law, calibration.settings.minimise, x, y)
        eta.append(fit.eta(np.repeat(casr, s)[:, None]).reshape(d, s))
    return np.asarray((eta[0] - eta[1]) / 2)
