"""How each law turns stiffness and score into the two axes of a straight line, eta = level + slope (X - X0).

law         | eta     | X
------------|---------|-----------
compliance  | 1/kappa | CASR^(3/2)
exponential | ln kappa| CASR
power       | ln kappa| ln CASR
linear-log  | kappa   | ln CASR

**The compliance law.** A soft dome of radius R on a softer or harder half-space touches it over a circle of radius a
with a^3 = 3 F R / (4 E*), and 1/E* = 1/E_s + 1/E_o: the compliances of sensor and specimen in series (Hertz 1881,
Journal fuer die reine und angewandte Mathematik 92, 156; Johnson, Contact Mechanics, 1985, eqs 4.22 to 4.25). The area
pi a^2 grows as (F/E*)^(2/3), so that its slope over the same forces goes as E*^(-2/3), and

    1/E* = c CASR^(3/2).

The stiffness that a flat punch of radius p measures on the specimen is kappa = 2 p E_o (Johnson, eq. 3.36). Together

    1/kappa = a + b CASR^(3/2),  a = -1 / (2 p E_s) < 0,  b > 0.

Two parameters: what the sensor itself gives way, and the scale of the score. The cosine of a tilted sensor and the
unit of the score go into b. The exponent follows from Hertz and is not fitted; a contact whose area grows as F^(3/10)
in place of F^(2/3) costs 3 % at most (decision 16). The indentation under a force goes as E*^(-2/3) too (Johnson,
eq. 4.23), which makes this the law of the kinesthetic cue, with millimetres per newton in place of CASR.
"""

from __future__ import annotations

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.settings import Law

HERTZ = 1.5
"Exponent of the score in the compliance law: 1/E* over dA/dF, or over mm per N, in a Hertz contact."


def x_of(law: Law, casr: Floats) -> Floats:
    """The score on the axis of the law; NaN where it has no logarithm or no root."""
    if law == "exponential":
        return casr
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        positive = np.where(casr > 0, casr, np.nan)
        return np.asarray(positive**HERTZ if law == "compliance" else np.log(positive))


def x_slope(law: Law, casr: Floats) -> Floats:
    """dX / dCASR."""
    if law == "exponential":
        return np.ones_like(casr)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        positive = np.where(casr > 0, casr, np.nan)
        return np.asarray(HERTZ * positive ** (HERTZ - 1) if law == "compliance" else 1 / positive)


def casr_of(law: Law, x: Floats) -> Floats:
    """The score at a place on the axis of the law; NaN where there is none."""
    if law == "exponential":
        return x
    with np.errstate(invalid="ignore", over="ignore"):
        return np.asarray(x ** (1 / HERTZ) if law == "compliance" else np.exp(x))


def eta_of(law: Law, kappa: Floats) -> Floats:
    """Stiffness > 0 on the axis of the law."""
    if law == "compliance":
        return np.asarray(1 / kappa)
    return kappa if law == "linear-log" else np.asarray(np.log(kappa))


def kappa_of(law: Law, eta: Floats) -> Floats:
    """Stiffness at a place on the axis of the law; a compliance of 0 or less has none: NaN."""
    if law == "linear-log":
        return eta
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        return np.asarray(np.where(eta > 0, 1 / eta, np.nan) if law == "compliance" else np.exp(eta))


def kappa_slope(law: Law, kappa: Floats) -> Floats:
    """dkappa / deta."""
    if law == "compliance":
        return np.asarray(-(kappa**2))
    return np.ones_like(kappa) if law == "linear-log" else kappa
