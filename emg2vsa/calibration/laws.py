"""The laws from CASR to stiffness, and three ways to fit each, all seen as one straight line.

A law is eta = level + slope (X - X0): eta is ln kappa or kappa, X is CASR or ln CASR, and X0 is where level and slope
are uncorrelated. What is made least square is the error of kappa (the paper), of ln kappa, or of CASR. The last is for
errors in x: kappa of the calibration specimens is known far better than a score, which the other two take as exact.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from emg2vsa.arrays import Floats, Ints
from emg2vsa.curves.exponential import ExponentialFit, fit_exponential, fit_exponential_log
from emg2vsa.curves.line import fit_line
from emg2vsa.curves.weighted_rows import weighted_rows
from emg2vsa.errors import SettingError

Law = Literal["exponential", "power", "linear-log"]
Minimise = Literal["kappa", "ln kappa", "casr"]
LAWS: tuple[Law, ...] = ("exponential", "power", "linear-log")


@dataclass(frozen=True)
class LawFit:
    """d fits of one law; every field (d,), NaN where undefined. level, slope and their standard errors are of eta."""

    law: Law
    x0: Floats
    level: Floats
    slope: Floats
    level_se: Floats
    slope_se: Floats
    n: Ints
    dof: Ints

    @property
    def parameters(self) -> Floats:
        """(d, 2): p and q of kappa = p exp(q CASR) or p CASR^q, or a and b of kappa = a + b ln CASR."""
        with np.errstate(over="ignore"):
            at_zero = self.level - self.slope * self.x0
            return np.stack([at_zero if self.law == "linear-log" else np.exp(at_zero), self.slope], axis=1)

    @property
    def parameter_se(self) -> Floats:
        """(d, 2) standard errors of ``parameters``."""
        with np.errstate(over="ignore", invalid="ignore"):
            at_zero = np.hypot(self.level_se, self.x0 * self.slope_se)
            unit = 1.0 if self.law == "linear-log" else self.parameters[:, 0]
            return np.stack([at_zero * unit, self.slope_se], axis=1)

    def at(self, casr: Floats) -> Floats:
        """kappa (d, m) at scores (d, m); NaN where the law has none (the logarithm of zero or less)."""
        with np.errstate(over="ignore"):
            eta = self.level[:, None] + self.slope[:, None] * (x_of(self.law, casr) - self.x0[:, None])
            return eta if self.law == "linear-log" else np.asarray(np.exp(eta))

    def se_at(self, casr: Floats) -> Floats:
        """Standard error (d, m) of the fitted kappa, from the fit alone."""
        with np.errstate(over="ignore", invalid="ignore"):
            distance = x_of(self.law, casr) - self.x0[:, None]
            of_eta = np.hypot(self.level_se[:, None], distance * self.slope_se[:, None])
            return of_eta if self.law == "linear-log" else np.asarray(of_eta * self.at(casr))

    def steepness(self, casr: Floats) -> Floats:
        """d kappa / d CASR (d, m)."""
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            by_eta = np.ones_like(casr) if self.law == "linear-log" else self.at(casr)
            by_x = np.ones_like(casr) if self.law == "exponential" else 1 / casr
            return np.asarray(by_eta * by_x * self.slope[:, None])


def x_of(law: Law, casr: Floats) -> Floats:
    """CASR, or its logarithm: NaN where it has none."""
    if law == "exponential":
        return casr
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(casr > 0, np.log(casr), np.nan)


def fit_law(law: Law, minimise: Minimise, casr: Floats, kappa: Floats) -> LawFit:
    """Fit kappa (d, n) > 0 on scores (d, n); NaN leaves a point out.

    A score of zero or less, where the law takes its logarithm, makes a fit undefined: leaving it out would flatter the
    law. SettingError for 'ln kappa' of the linear-log law, which is linear in kappa.
    """
    if law == "linear-log" and minimise == "ln kappa":
        raise SettingError(
            "calibration", wanted="'kappa' or 'casr' for the linear-log law", found=repr(minimise), do="Choose one."
        )
    x = x_of(law, casr)
    lost = np.any(np.isnan(x) & ~np.isnan(casr), axis=1)
    x = np.where(lost[:, None], np.nan, x)
    if minimise == "casr":
        return _inverse(law, x, kappa)
    if law == "linear-log":
        return _straight(law, x, kappa)
    return _of_exponential(law, (fit_exponential if minimise == "kappa" else fit_exponential_log)(x, kappa))


def _of_exponential(law: Law, fit: ExponentialFit) -> LawFit:
    with np.errstate(divide="ignore", invalid="ignore"):
        level = np.log(np.where(fit.y0 > 0, fit.y0, np.nan))
    return LawFit(law, fit.x0, level, fit.q, fit.level_se, fit.q_se, fit.n, fit.dof)


def _straight(law: Law, x: Floats, eta: Floats) -> LawFit:
    rows = weighted_rows(x, eta, None, where="calibration")
    line = fit_line(rows.x - rows.x_centre[:, None], rows.y, rows.w)
    return LawFit(law, rows.x_centre, line.intercept, line.slope, line.intercept_se, line.slope_se, line.n, line.dof)


def _inverse(law: Law, x: Floats, kappa: Floats) -> LawFit:
    """The line of X on eta, turned round: X - X0 = (eta - level) / slope."""
    eta = kappa if law == "linear-log" else np.log(kappa)
    turned = _straight(law, eta, x)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.where(turned.slope != 0, 1 / turned.slope, np.nan)
        return LawFit(
            law,
            x0=turned.level,
            level=turned.x0 + 0 * slope,
            slope=slope,
            level_se=turned.level_se * np.abs(slope),
            slope_se=turned.slope_se * slope**2,
            n=turned.n,
            dof=turned.dof,
        )
