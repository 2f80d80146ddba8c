"""The moving part of the rig: a cogwheel on the shaft drives the sensor down onto the specimen."""

from __future__ import annotations

import math

from casr.synthetic import ContactWorld
from emg2vsa.rig.emulated.world_settings import WorldSettings


class SpecimenContact:
    """Force of the soft dome on a specimen: the contact radius that the camera shows decides it.

    An axisymmetric contact of radius a resists a further approach with dF/dd = 2 E* a (Sneddon 1965, Int. J. Eng. Sci.
    3, 47; Pharr, Oliver and Brotzen 1992, Journal of Materials Research 7, 613). With the radius law of
    ``casr.synthetic.ContactWorld``, a = R (c F)^n with c = 3/(4 E* R^2), this integrates to

        d = F^(1 - n) / (2 (1 - n) E* R c^n)

    which for n = 1/3 is Hertz, F = 4/3 E* sqrt(R) d^(3/2). E* has sensor and specimen in series. No friction and no
    adhesion, as Hertz has it: the force stands along the normal of the specimen's surface. Forces in N, depths in mm.

    Parameters
    ----------
    contact : mechanics of sensor and specimen; exponent below 1.
    stiffness_n_per_mm : of the specimen.
    """

    def __init__(self, contact: ContactWorld, stiffness_n_per_mm: float) -> None:
        n, radius_mm = contact.exponent, contact.tip_radius_mm
        modulus_mpa = contact.modulus_mpa(stiffness_n_per_mm)
        c = 3 / (4 * modulus_mpa * radius_mm**2)
        self._power = 1 / (1 - n)
        self._per_mm = 2 * (1 - n) * modulus_mpa * radius_mm * c**n

    def force_n(self, depth_mm: float) -> float:
        """Normal force at an indentation along the normal; exactly 0 without one."""
        return (self._per_mm * depth_mm) ** self._power if depth_mm > 0 else 0.0

    def resistance(self, depth_mm: float) -> tuple[float, float]:
        """Force, N, and its growth per indentation, N/mm."""
        force_n = self.force_n(depth_mm)
        return force_n, self._power * force_n / depth_mm if depth_mm > 0 else 0.0


class PlateContact:
    """Force of a flat plate on a specimen, F = kappa d: what stiffness by plate indentation means (paper, IV.B)."""

    def __init__(self, stiffness_n_per_mm: float) -> None:
        self._stiffness_n_per_mm = stiffness_n_per_mm

    def force_n(self, depth_mm: float) -> float:
        """As `SpecimenContact`."""
        return self._stiffness_n_per_mm * max(0.0, depth_mm)

    def resistance(self, depth_mm: float) -> tuple[float, float]:
        """As `SpecimenContact`."""
        return self.force_n(depth_mm), self._stiffness_n_per_mm if depth_mm > 0 else 0.0


Force = tuple[float, float, float]


class Probe:
    """Where the probe is with the shaft at an angle, and what pushes back. A larger angle is further down."""

    def __init__(self, settings: WorldSettings) -> None:
        stiffness = settings.stiffness_n_per_mm
        self._contact = PlateContact(stiffness) if settings.plate else SpecimenContact(settings.contact, stiffness)
        self._mm_per_rad = math.degrees(settings.mm_per_degree)
        tilt = math.radians(settings.angle_deg)
        self._sin, self._cos = math.sin(tilt), math.cos(tilt)
        # work along the axis is work along the normal: both the force and the indentation take a cosine
        self._depth_mm_per_rad = self._cos * self._mm_per_rad
        self._lever_m_per_rad = self._depth_mm_per_rad / 1000
        self.touch_rad = settings.gap_mm / self._mm_per_rad
        "Shaft angle at first contact."

    def position_mm(self, shaft_rad: float) -> float:
        """Way down from where the shaft is at 0."""
        return shaft_rad * self._mm_per_rad

    def above_mm(self, shaft_rad: float) -> float:
        """Way down from there to first contact."""
        return (self.touch_rad - shaft_rad) * self._mm_per_rad

    def normal_force_n(self, shaft_rad: float) -> float:
        """Force along the normal of the specimen's surface; exactly 0 without contact."""
        return self._contact.force_n(self._depth_mm(shaft_rad))

    def force_n(self, shaft_rad: float) -> Force:
        """Force on the specimen: x the way its surface falls off, y, and z down the probe's axis, so pressing is +."""
        normal_n = self.normal_force_n(shaft_rad)
        return normal_n * self._sin, 0.0, normal_n * self._cos

    def torque_nm(self, shaft_rad: float) -> tuple[float, float]:
        """What holds the shaft back, N m, and its growth, N m/rad. The tilted guide takes the force across it."""
        depth_mm = self._depth_mm(shaft_rad)
        if depth_mm <= 0:
            return 0.0, 0.0
        force_n, growth_n_per_mm = self._contact.resistance(depth_mm)
        return force_n * self._lever_m_per_rad, growth_n_per_mm * self._depth_mm_per_rad * self._lever_m_per_rad

    def _depth_mm(self, shaft_rad: float) -> float:
        return (shaft_rad - self.touch_rad) * self._depth_mm_per_rad
