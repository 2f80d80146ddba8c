"""The laws from CASR to stiffness, and three ways to fit each, all seen as one straight line (``forms``).

A law is eta = level + slope (X - X0), and X0 is where level and slope are uncorrelated. What is made least square is
the error of kappa (the paper), of ln kappa, or of CASR. The last is for errors in x: kappa of the calibration specimens
is known far better than a score, which the other two take as exact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats
from emg2vsa.calibration.forms import casr_of, eta_of, kappa_of, kappa_slope, x_of, x_slope
from emg2vsa.curves.exponential import ExponentialFit, fit_exponential, fit_exponential_log
from emg2vsa.curves.line import fit_line, weighted_rows
from emg2vsa.errors import SettingError
from emg2vsa.settings import Law, Minimise

WAYS: dict[Law, tuple[Minimise, ...]] = {
    "compliance": ("casr",),
    "exponential": ("casr", "kappa", "ln kappa"),
    "power": ("casr", "kappa", "ln kappa"),
    "linear-log": ("casr", "kappa"),
}
"""What can be made least square with each law."""
LAWS = tuple(WAYS)


@dataclass(frozen=True)
class LawFit:
    """d fits of one law; every field (d,), NaN where undefined. level, slope : of eta."""

    law: Law
    x0: Floats
    level: Floats
    slope: Floats

    @property
    def parameters(self) -> Floats:
        """(d, 2): p and q of kappa = p exp(q CASR) or p CASR^q; else a and b of eta = a + b X."""
        with np.errstate(over="ignore"):
            at_zero = self.level - self.slope * self.x0
            return np.stack([np.exp(at_zero) if self._logarithmic else at_zero, self.slope], axis=1)

    @property
    def rises(self) -> NDArray[np.bool_]:
        """(d,) whether kappa rises with CASR, which no soft specimen does."""
        return np.asarray(self.slope < 0 if self.law == "compliance" else self.slope > 0)

    def eta(self, casr: Floats) -> Floats:
        """eta (d, m) at scores (d, m)."""
        with np.errstate(over="ignore"):
            return np.asarray(self.level[:, None] + self.slope[:, None] * (x_of(self.law, casr) - self.x0[:, None]))

    def at(self, casr: Floats) -> Floats:
        """kappa (d, m) at scores (d, m); NaN where the law has none."""
        return kappa_of(self.law, self.eta(casr))

    def casr(self, kappa: Floats) -> Floats:
        """The score (d, m) of stiffnesses (d, m); NaN where the law has none."""
        with np.errstate(divide="ignore", invalid="ignore"):
            x = self.x0[:, None] + (eta_of(self.law, kappa) - self.level[:, None]) / self.slope[:, None]
        return casr_of(self.law, x)

    def steepness(self, casr: Floats) -> Floats:
        """d kappa / d CASR (d, m)."""
        with np.errstate(over="ignore", invalid="ignore"):
            return np.asarray(kappa_slope(self.law, self.at(casr)) * x_slope(self.law, casr) * self.slope[:, None])

    @property
    def _logarithmic(self) -> bool:
        return self.law in ("exponential", "power")


def fit_law(law: Law, minimise: Minimise, casr: Floats, kappa: Floats) -> LawFit:
    """Fit kappa (d, n) > 0 on scores (d, n); NaN leaves a point out.

    A score of zero or less, where the law takes its logarithm or root, makes a fit undefined: leaving it out would
    flatter the law. SettingError where the law is not fitted this way (``WAYS``).
    Least squares of kappa by the exponential law is the paper's way.
    """
    if minimise not in WAYS[law]:
        raise SettingError(
            "calibration",
            wanted=" or ".join(map(repr, WAYS[law])) + f" for the {law} law",
            found=repr(minimise),
            do="Choose one of these laws.",
        )
    x = x_of(law, casr)
    lost = np.any(np.isnan(x) & ~np.isnan(casr), axis=1)
    x = np.where(lost[:, None], np.nan, x)
    if minimise == "casr":
        return _inverse(law, x, x_slope(law, casr), kappa)
    if law == "linear-log":
        return _straight(law, x, kappa, None)
    return _of_exponential(law, (fit_exponential if minimise == "kappa" else fit_exponential_log)(x, kappa))


def _of_exponential(law: Law, fit: ExponentialFit) -> LawFit:
    with np.errstate(divide="ignore", invalid="ignore"):
        level = np.log(np.where(fit.y0 > 0, fit.y0, np.nan))
    return LawFit(law, fit.x0, level, fit.q)


def _straight(law: Law, x: Floats, eta: Floats, weights: Floats | None) -> LawFit:
    rows = weighted_rows(x, eta, weights, where="calibration")
    line = fit_line(rows.x - rows.x_centre[:, None], rows.y, rows.w)
    return LawFit(law, rows.x_centre, line.intercept, line.slope)


def _inverse(law: Law, x: Floats, slope_of_x: Floats, kappa: Floats) -> LawFit:
    """The line of X on eta, turned round: X - X0 = (eta - level) / slope. An error of CASR moves X by dX/dCASR."""
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        weights = (np.nanmin(slope_of_x, axis=1, keepdims=True, initial=np.inf) / slope_of_x) ** 2
    turned = _straight(law, eta_of(law, kappa), x, weights)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.where(turned.slope != 0, 1 / turned.slope, np.nan)
        return LawFit(law, x0=turned.level, level=turned.x0 + 0 * slope, slope=slope)
