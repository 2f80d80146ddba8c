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

**A mounting whose angle is off** moves every press alike, so that the presses of one mounting cannot show it. Under a
probe that is tilted by theta the force along its axis is F = N cos(theta) of the normal force N, the indentation takes
1 / cos(theta) of travel, and the camera sees cos(theta) of the contact's area. Over the same forces F, therefore

    dA/dF ~ cos(theta)^(1/3),  travel per newton ~ cos(theta)^(-5/3),

and an area that is not foreshortened, as that of the contact's front, has dA/dF ~ cos(theta)^(-2/3).

An error of theta moves CASR by -(1/3) tan(theta) of itself per radian and the millimetres per newton by
(5/3) tan(theta): nothing along the normal, and at 45 degrees 0.3 % and 1.5 % for half a degree.

**The power by which the contact grows**, as the presses themselves show it, says what the exponent should be. If the
area depends on F/E* alone, as it must in any elastic contact that one modulus describes, then A ~ F^p is A ~ (F/E*)^p:
the score goes as E*^(-p), and 1/E* as CASR^(1/p). Hertz has p = 2/3. The stiffness of a round contact is
2 E* sqrt(A/pi) whatever the shape of the bodies (Pharr, Oliver and Brotzen 1992, Journal of Materials Research 7, 613),
so that the indentation goes as F^(1 - p/2) E*^(p/2 - 1), and 1/E* as the millimetres per newton to the power of
1/(1 - p/2).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.run_scores import RunScores
from emg2vsa.settings import Law

HERTZ = 1.5
"Exponent of the score in the compliance law: 1/E* over dA/dF, or over mm per N, in a Hertz contact."
CASR_POWER, FRONT_POWER, INDENTATION_POWER = 1 / 3, -2 / 3, -5 / 3
"Power of cos(theta) in a score: of areas in the image, of areas of the contact's front, and of indentations."
FRONT_SHARE = 0.01
"""Share of a score by the contact's front by which its error differs between specimens of one sensor, however often
they are pressed: what of it they share calibrates out, domes that the library does not hold leave 0.7 to 1.3 %.
"""
_LEAST_FRAMES = 3
_MOST_POWER = 2.0  # a contact growing faster would not resist at all


def x_of(law: Law, casr: Floats) -> Floats:
    """The score on the axis X of the law, an array of the shape of ``casr``; NaN where it has no logarithm or no root.

    The compliance law follows from Hertz (1881); the exponential law is the paper's.
    """
    if law == "exponential":
        return casr
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        positive = np.where(casr > 0, casr, np.nan)
        return np.asarray(positive**HERTZ if law == "compliance" else np.log(positive))


def casr_of(law: Law, x: Floats) -> Floats:
    """The score at places (n,) on the axis of the law (compliance: Hertz 1881): the inverse of ``x_of``. NaN where
    there is none."""
    if law == "exponential":
        return x
    with np.errstate(invalid="ignore", over="ignore"):
        return np.asarray(np.where(x > 0, x, np.nan) ** (1 / HERTZ) if law == "compliance" else np.exp(x))


def x_slope(law: Law, casr: Floats) -> Floats:
    """dX / dCASR at scores (n,), for the error of a score on the axis."""
    if law == "exponential":
        return np.ones_like(casr)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        positive = np.where(casr > 0, casr, np.nan)
        return np.asarray(HERTZ * positive ** (HERTZ - 1) if law == "compliance" else 1 / positive)


def eta_of(law: Law, kappa: Floats) -> Floats:
    """Stiffness (n,) > 0, N/mm, on the axis eta of the law (compliance: Johnson 1985, eqs 3.36 and 4.22; exponential:
    the paper's)."""
    if law == "compliance":
        return np.asarray(1 / kappa)
    return kappa if law == "linear-log" else np.asarray(np.log(kappa))


def kappa_of(law: Law, eta: Floats) -> Floats:
    """Stiffness (n,), N/mm, at a place on the axis of the law (compliance: Johnson 1985, eq. 3.36); a compliance of 0
    or less has none: NaN."""
    if law == "linear-log":
        return eta
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        return np.asarray(np.where(eta > 0, 1 / eta, np.nan) if law == "compliance" else np.exp(eta))


def kappa_slope(law: Law, kappa: Floats) -> Floats:
    """dkappa / deta at stiffnesses (n,), N/mm."""
    if law == "compliance":
        return np.asarray(-(kappa**2))
    return np.ones_like(kappa) if law == "linear-log" else kappa


def specimen_share(algorithm: str) -> float:
    """Standard deviation of CASR between specimens that neither presses nor mountings show, as a share of it."""
    return FRONT_SHARE if algorithm == "front" else 0.0


def casr_angle_share(algorithm: str, angle_deg: float, angle_sd_deg: float) -> float:
    """``mount_share`` of CASR by this vision algorithm. angle_deg, angle_sd_deg : degrees."""
    return mount_share(FRONT_POWER if algorithm == "front" else CASR_POWER, angle_deg, angle_sd_deg)


def mount_share(power: float, angle_deg: float, angle_sd_deg: float) -> float:
    """Change of a score that goes as cos(angle)^power for one standard deviation of the angle, as a share of it. Both
    angles in degrees."""
    return -power * math.tan(math.radians(angle_deg)) * math.radians(angle_sd_deg)


def growth_power(runs: Sequence[RunScores]) -> float:
    """p of A ~ F^p: the median over presses of the slope of ln A over ln F in the loading phase; NaN without curves.

    In a contact that grows as a power of F/E* the score goes as E*^(-p), whatever p is; Hertz has 2/3.
    """
    powers = []
    for curve in (curve for run in runs for curve in run.curves):
        usable = (curve.force_n > 0) & (curve.area_mm2 > 0)
        if np.count_nonzero(usable) >= _LEAST_FRAMES:
            x, y = np.log(curve.force_n[usable]), np.log(curve.area_mm2[usable])
            x -= x.mean()
            powers.append(float(x @ y / (x @ x)))
    return float(np.median(powers)) if powers else float("nan")


def casr_exponent(power: float) -> float:
    """Exponent of CASR in the compliance law for a contact that grows as F^power; Hertz's where it is not known."""
    return 1 / power if power > 0 else HERTZ


def indentation_exponent(power: float) -> float:
    """The same of millimetres per newton."""
    return 1 / (1 - power / 2) if 0 < power < _MOST_POWER else HERTZ
