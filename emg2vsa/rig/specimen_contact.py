"""Force of the tactile dome on a specimen of known stiffness, by depth."""

from __future__ import annotations

from typing import Self

from casr.synthetic import ContactWorld


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

    @classmethod
    def of(cls, stiffness_n_per_mm: float) -> Self:
        """Of the dome as the emulated camera draws it."""
        return cls(ContactWorld(), stiffness_n_per_mm)

    def force_n(self, depth_mm: float) -> float:
        """Normal force at an indentation along the normal; exactly 0 without one."""
        return (self._per_mm * depth_mm) ** self._power if depth_mm > 0 else 0.0

    def depth_mm(self, force_n: float) -> float:
        """Indentation along the normal at a normal force."""
        return float(force_n ** (1 / self._power) / self._per_mm)

    def resistance(self, depth_mm: float) -> tuple[float, float]:
        """Force, N, and its growth per indentation, N/mm."""
        force_n = self.force_n(depth_mm)
        return force_n, self._power * force_n / depth_mm if depth_mm > 0 else 0.0
