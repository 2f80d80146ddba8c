"""The elastic contact of the tactile dome and a specimen of known stiffness."""

from __future__ import annotations

from casr.synthetic import ContactWorld
from emg2vsa.contact_mechanics import PowerLaw


def specimen_contact(stiffness_n_per_mm: float, contact: ContactWorld | None = None) -> PowerLaw:
    """Force over depth of a dome whose radius grows as that of ``contact``, by default that of the emulated rig."""
    contact = contact or ContactWorld()
    return PowerLaw(contact.modulus_mpa(stiffness_n_per_mm), contact.tip_radius_mm, contact.exponent)
