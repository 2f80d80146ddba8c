"""Force of the tactile dome on a specimen of known stiffness, by depth."""

from __future__ import annotations

from typing import Self

from casr.synthetic import ContactWorld
from emg2vsa.contact_mechanics import PowerLaw


class SpecimenContact(PowerLaw):
    """Force of the soft dome on a specimen, whose contact radius is that of ``casr.synthetic.ContactWorld``.

    Parameters
    ----------
    contact : mechanics of sensor and specimen; exponent below 1.
    stiffness_n_per_mm : of the specimen.
    """

    def __init__(self, contact: ContactWorld, stiffness_n_per_mm: float) -> None:
        super().__init__(contact.modulus_mpa(stiffness_n_per_mm), contact.tip_radius_mm, contact.exponent)

    @classmethod
    def of(cls, stiffness_n_per_mm: float) -> Self:
        """Of the dome as the emulated camera draws it."""
        return cls(ContactWorld(), stiffness_n_per_mm)
