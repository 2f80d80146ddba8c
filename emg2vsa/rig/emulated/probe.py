"""The moving part of the rig: a cogwheel on the shaft drives the sensor down onto the specimen."""

from __future__ import annotations

import math

from emg2vsa.rig.emulated.world_settings import WorldSettings
from emg2vsa.rig.specimen_contact import SpecimenContact


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
