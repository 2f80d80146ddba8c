"""Laws of rubber for a cylinder pressed between two plates: Hooke, Neo-Hooke, Yeoh, Ogden; its modulus with interval.

Engineering stress over the stretch s = 1 - depth / height of an incompressible body (Treloar 1975, The Physics of
Rubber Elasticity), E the initial Young's modulus:

    line        E (1 - s)
    neo-hooke   E / 3 (s^-2 - s)
    yeoh        (s^-2 - s) (E / 3 + c (2 / s + s^2 - 3))
    ogden       2 E / (3 a) (s^(-a/2 - 1) - s^(a - 1))

Ends that cannot slide make the cylinder stiffer (casr.dome.kappa): right at small strains, less so at large ones.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from casr.dome.kappa import plate_on_cylinder_mm
from emg2vsa.arrays import Floats
from emg2vsa.curves.first_contact import left_over
from emg2vsa.curves.force_range import RangeFit, t_975
from emg2vsa.curves.line import fit_line

STRAIN = 0.05
"""Strain from contact on, over which the modulus is the slope of a line with frictionless ends: of the ranges and
laws that were tried on ten published mixtures, the only one within 6.5 % or two published SDs in all ten (decision
50).
"""
_MOST_STRAIN = 0.4
_LEAST = 12
Ends = Literal["frictionless", "bonded"]


@dataclass(frozen=True)
class Cylinder:
    """Between two plates; mm. ends : whether they slide (lubricated) or cannot."""

    diameter_mm: float
    height_mm: float
    ends: Ends = "frictionless"

    @property
    def bonding(self) -> float:
        """Factor by which ends that cannot slide make the cylinder stiffer."""
        radius_mm = self.diameter_mm / 2
        sliding_mm = plate_on_cylinder_mm(radius_mm, self.height_mm)
        return plate_on_cylinder_mm(radius_mm, self.height_mm, bonded=True) / sliding_mm

    @property
    def n_per_mm_per_kpa(self) -> float:
        """Stiffness at small depth over Young's modulus."""
        return 1e-3 * plate_on_cylinder_mm(self.diameter_mm / 2, self.height_mm, bonded=self.ends == "bonded")

    def force_n(self, depth_mm: Floats, modulus_kpa: float, second: float = 1.0, law: str = "neo-hooke") -> Floats:
        """Force (n,), N, at this depth (n,), mm, past contact, below the height (Treloar 1975). modulus_kpa : E,
        kPa."""
        stretch = 1 - np.maximum(depth_mm, 0) / self.height_mm
        return np.asarray(self.n_per_mm_per_kpa * self.height_mm * LAWS[law](stretch, modulus_kpa, second))


def _ogden(s: Floats, modulus: float, power: float) -> Floats:
    power = power if abs(power) > 1e-6 else 1e-6
    return np.asarray(2 * modulus / (3 * power) * (s ** (-power / 2 - 1) - s ** (power - 1)))


LAWS: dict[str, Callable[[Floats, float, float], Floats]] = {
    "line": lambda s, modulus, _: modulus * (1 - s),
    "neo-hooke": lambda s, modulus, _: modulus / 3 * (s**-2 - s),
    "yeoh": lambda s, modulus, c: (s**-2 - s) * (modulus / 3 + c * (2 / s + s**2 - 3)),
    "ogden": _ogden,
}
"""Name to engineering stress of compression, kPa, over stretch, modulus and the second constant: c in kPa, power a."""


@dataclass(frozen=True)
class LawFit:
    """modulus_kpa, modulus_se_kpa : initial Young's modulus. second : constant of the law, NaN where it has none.
    left_n : root mean square of what it leaves. aicc : Akaike's criterion, as if what is left were independent over its
    own correlation; smaller is better, within one press."""

    law: str
    modulus_kpa: float
    modulus_se_kpa: float
    second: float
    left_n: float
    aicc: float


@dataclass(frozen=True)
class Rubber:
    """Rubber laws of one press. modulus_kpa, modulus_se_kpa : by a line over the first 5 % of strain. laws : over
    the range of the press, up to 40 % of strain. NaN, and no laws, where the press says none.
    """

    modulus_kpa: float
    modulus_se_kpa: float
    laws: tuple[LawFit, ...]


def fit_rubber(depth_mm: Floats, force_n: Floats, cylinder: Cylinder, press: RangeFit) -> Rubber:
    """Laws of rubber through one press (Treloar 1975).

    depth_mm, force_n : (n,) mm and N of the loading, as ``loading`` gives it. press : its fit over a range of force.
    """
    if press.rating == "unusable":
        return Rubber(np.nan, np.nan, ())
    deepest = press.contact + _MOST_STRAIN * cylinder.height_mm
    near = (depth_mm >= press.contact_low) & (depth_mm <= min(press.depth_to, deepest))
    x, y = depth_mm[near], force_n[near] - press.level_n
    laws = tuple(_laws(x, y, cylinder, press)) if x.size >= _LEAST else ()
    return Rubber(*_modulus(depth_mm, force_n, cylinder, press), laws)


def _modulus(x: Floats, y: Floats, cylinder: Cylinder, press: RangeFit) -> tuple[float, float]:
    """Slope over the first strain from contact on, kPa, with its error: that of the line, and that of contact."""
    slopes = []
    for touch in (press.contact, press.contact_low, press.contact_high):
        inside = (x >= touch) & (x <= touch + STRAIN * cylinder.height_mm)
        if np.count_nonzero(inside) < _LEAST or x.max() < touch + STRAIN * cylinder.height_mm:
            return np.nan, np.nan
        line = fit_line(x[None, inside], y[None, inside])
        left = y[inside] - line.intercept[0] - line.slope[0] * x[inside]
        slopes.append((float(line.slope[0]), float(line.slope_se[0]) * np.sqrt(left_over(left, y[inside], 2)[1])))
    (slope, within), (low, _), (high, _) = slopes
    error = float(np.hypot(within, (high - low) / (2 * t_975(np.inf))))
    return slope / cylinder.n_per_mm_per_kpa, error / cylinder.n_per_mm_per_kpa


def _laws(x: Floats, y: Floats, cylinder: Cylinder, press: RangeFit) -> Iterator[LawFit]:
    """Least squares over the place of contact and the constants of each law."""
    from scipy.optimize import least_squares  # noqa: PLC0415  (0.2 s that presses of unknown size do not need)

    start = max(press.secant / cylinder.n_per_mm_per_kpa, 1e-6)
    found = {}
    for law in LAWS:
        second = {"yeoh": [0.0], "ogden": [2.0]}.get(law, [])
        scale = [0.01 * cylinder.height_mm, start, *([start] if law == "yeoh" else [1.0] * len(second))]

        def residual(constants: Floats, law: str = law) -> Floats:
            touch, modulus, second = (*constants, 0.0)[:3]
            return cylinder.force_n(x - touch, modulus, second, law) - y

        found[law] = least_squares(residual, [press.contact, start, *second], x_scale=scale)
    left = {law: left_over(each.fun, y, each.x.size) for law, each in found.items()}
    alike = min(longer for _, longer in left.values())  # what the best law leaves is noise
    for law, each in found.items():
        (square, longer), p, n = left[law], each.x.size, x.size / alike
        jac = np.asarray(each.jac)
        covariance = square / max(x.size - p, 1) * longer * np.linalg.pinv(jac.T @ jac)
        yield LawFit(
            law, float(each.x[1]), float(np.sqrt(covariance[1, 1])), float(each.x[2]) if p > 2 else np.nan,
            float(np.sqrt(square / x.size)),
            float(n * np.log(square / x.size) + 2 * (p + 1) * n / max(n - p - 2, 0.1)),
        )  # fmt: skip
