"""Elastic contact of the tactile dome on a flat specimen of known stiffness: depth, radius and area at a force.

A rig takes from here what it expects of a press, and the made worlds begin with it. With relaxation or adhesion the
same curves hold at another force: the convolved one, or the one that adhesion adds to.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from casr.dome.kappa import punch_on_half_space_mm
from emg2vsa.arrays import Floats
from emg2vsa.errors import SettingError

SHEAR_OVER_NORMAL = 2 / 3
"Ratio of the tangential to the normal stiffness of a contact between incompressible bodies."


class PowerLaw:
    """A dome whose contact radius is a = R (c F)^n with c = 3 / (4 E* R^2); n = 1/3 is Hertz.

    An axisymmetric contact of radius a resists a further approach with dF/dd = 2 E* a (Sneddon 1965, Int. J. Eng. Sci.
    3, 47; Pharr, Oliver and Brotzen 1992, Journal of Materials Research 7, 613). This integrates to

        d = F^(1 - n) / (2 (1 - n) E* R c^n)

    which for n = 1/3 is F = 4/3 E* sqrt(R) d^(3/2). The force stands along the normal of the specimen's surface.

    Parameters
    ----------
    modulus_mpa : E*, the reduced modulus of sensor and specimen in series.
    tip_radius_mm : R. exponent : n, above 0 and below 1; SettingError otherwise.
    """

    def __init__(self, modulus_mpa: float, tip_radius_mm: float = 20.0, exponent: float = 0.25) -> None:
        for name, value in (("modulus_mpa", modulus_mpa), ("tip_radius_mm", tip_radius_mm)):
            if not (math.isfinite(value) and value > 0):
                raise SettingError(name, wanted="a number above 0", found=repr(value), do="Correct the contact.")
        if not 0 < exponent < 1:
            raise SettingError(
                "exponent", wanted="a number between 0 and 1", found=repr(exponent), do="Correct the contact."
            )
        self.modulus_mpa, self.tip_radius_mm, self.exponent = modulus_mpa, tip_radius_mm, exponent
        c = 3 / (4 * modulus_mpa * tip_radius_mm**2)
        self._unit_n, self.power = 4 * modulus_mpa * tip_radius_mm**2 / 3, 1 / (1 - exponent)
        self.per_mm = 2 * (1 - exponent) * modulus_mpa * tip_radius_mm * c**exponent

    def force_n(self, depth_mm: float) -> float:
        """Normal force, N, at an indentation along the normal, mm; exactly 0 without one."""
        return (self.per_mm * depth_mm) ** self.power if depth_mm > 0 else 0.0

    def depth_mm(self, force_n: float) -> float:
        """Indentation along the normal, mm, at a normal force, N."""
        return float(force_n ** (1 / self.power) / self.per_mm)

    def resistance(self, depth_mm: float) -> tuple[float, float]:
        """Force, N, and its growth per indentation, N/mm."""
        if depth_mm <= 0:
            return 0.0, 0.0
        force_n = (self.per_mm * depth_mm) ** self.power
        return force_n, self.power * force_n / depth_mm

    def radius_mm(self, force_n: ArrayLike) -> Floats:
        """Contact radius, mm, at normal forces, N, of any shape; 0 where nothing presses (Hertz 1881 for n = 1/3)."""
        force = np.maximum(np.asarray(force_n, dtype=np.float64), 0.0)
        return np.asarray(self.tip_radius_mm * (force / self._unit_n) ** self.exponent, dtype=np.float64)

    def area_mm2(self, force_n: ArrayLike) -> Floats:
        """Contact area, mm2, at normal forces, N, of any shape."""
        return np.asarray(np.pi * self.radius_mm(force_n) ** 2, dtype=np.float64)


@dataclass(frozen=True, kw_only=True)
class ElasticDome:
    """The dome, and the plate that measured the specimen's stiffness.

    Parameters
    ----------
    tip_radius_mm : radius of the dome; the TacTip's tip is 40 mm wide (source: the sensor).
    exponent : of the contact radius over force. 1/4 lies inside the range of a nonlinear soft finger, n/(2n+1) <= 1/3
        (source: Xydas and Kao 1999); 1/3 is Hertz.
    sensor_modulus_mpa : reduced modulus of the dome (guess).
    punch_radius_mm : radius of the flat punch that measured the specimen's stiffness, as on a half-space (guess).
    """

    tip_radius_mm: float = 20.0
    exponent: float = 0.25
    sensor_modulus_mpa: float = 0.4
    punch_radius_mm: float = 5.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and value > 0):
                raise SettingError(field.name, wanted="a number above 0", found=repr(value), do="Correct the contact.")

    def specimen_mpa(self, stiffness_n_per_mm: float) -> float:
        """Reduced modulus of a specimen, MPa, from its stiffness, N/mm (Sneddon 1965: a flat punch on a half-space)."""
        return stiffness_n_per_mm / punch_on_half_space_mm(self.punch_radius_mm)

    def modulus_mpa(self, stiffness_n_per_mm: float) -> float:
        """Reduced modulus of dome and specimen in series, MPa, from the specimen's stiffness, N/mm."""
        return 1 / (1 / self.sensor_modulus_mpa + 1 / self.specimen_mpa(stiffness_n_per_mm))

    def stiffness_n_per_mm(self, modulus_mpa: float) -> float:
        """Of the specimen with which dome and specimen in series have this modulus; infinite from the dome's own on."""
        if modulus_mpa >= self.sensor_modulus_mpa:
            return math.inf
        return punch_on_half_space_mm(self.punch_radius_mm) / (1 / modulus_mpa - 1 / self.sensor_modulus_mpa)

    def on(self, stiffness_n_per_mm: float) -> PowerLaw:
        """Its contact with a specimen of this stiffness, N/mm."""
        return PowerLaw(self.modulus_mpa(stiffness_n_per_mm), self.tip_radius_mm, self.exponent)
