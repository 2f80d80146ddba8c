"""How far an estimate moves with every number that went into it, by refitting beside it; any law, any way to fit."""

from __future__ import annotations

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.calibration.calibrate import Calibration, fitted_points
from emg2vsa.calibration.forms import HERTZ
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


def by_exponent(calibration: Calibration, casr: Floats) -> Floats:
    """Change of eta (d,) of the estimate at score ``casr`` (d,), were the exponent of the compliance law the other one.

    1/kappa over CASR^m is the law itself over scores raised to m / (3/2).
    """
    settings, power = calibration.settings, calibration.other_exponent / HERTZ
    if settings.law != "compliance":
        return np.zeros_like(casr)
    with np.errstate(invalid="ignore", over="ignore"):
        raised, known = casr**power, calibration.casr**power
    fit = fit_law(settings.law, settings.minimise, *fitted_points(known, calibration.kappa, settings.points))
    return np.asarray((fit.eta(raised[:, None]) - calibration.fit.eta(casr[:, None]))[:, 0])


def _difference(calibration: Calibration, casr: Floats, score_step: Floats, kappa_step: Floats) -> Floats:
    """Half of the change of eta (d, S) between one specimen's score and kappa moved up and both moved down."""
    d, s, r = calibration.casr.shape
    move = np.array([1.0, -1.0])[:, None, None, None] * np.eye(s)  # (up or down, 1, moved specimen, specimen)
    scores = calibration.casr[:, None] + (move * score_step[:, None])[..., None]
    known = calibration.kappa[:, None] + move * kappa_step[:, None]
    x, y = fitted_points(scores.reshape(2 * d * s, s, r), known.reshape(2 * d * s, s), calibration.settings.points)
    fit = fit_law(calibration.settings.law, calibration.settings.minimise, x, y)
    up, down = fit.eta(np.tile(np.repeat(casr, s), 2)[:, None]).reshape(2, d, s)
    return np.asarray((up - down) / 2)
