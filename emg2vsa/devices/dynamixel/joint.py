"""A position gain as a spring: the motor pulls towards its command in proportion to the distance, and to the gain.

In current-based position control the wanted current is the P gain times the position error (ROBOTIS e-Manual, Position
PID Gain). That holds up to the goal current; beyond it the torque no longer grows, and is smaller than told here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats
from emg2vsa.devices.joints import Export
from emg2vsa.devices.protocols import Measurements
from emg2vsa.errors import ScheduleError


@dataclass(frozen=True)
class GainJoint:
    """The stiffness is proportional to the gain; a preset is a share of it.

    full_preset : stiffness at preset 1, N m/rad. full_gain : whole gain there; None where no device is at hand.
    """

    full_preset: float
    full_gain: int | None = None
    name: str = "dynamixel"
    measured_key: str | None = "full_stiffness_nm_per_rad"
    preset_per_s: float = 2.5
    settles_s: float = 0.3

    def targets_deg(self, position_deg: float, preset: float) -> tuple[float, ...]:
        """No angle (degrees) of any motor: the motor gives way itself, and does not stand at its command under load."""
        return ()

    def torque_nm(self, at: Measurements, position_deg: float, preset: float) -> float:
        """External torque that the joint bears, N m; positive when the shaft is at a larger angle than commanded."""
        return self.full_preset * preset * math.radians(at.shaft_deg - position_deg)

    def position_deg(self, at: Measurements) -> float:
        """The motor's."""
        return at.motors_deg[0]

    def preset_at(self, at: Measurements) -> float:
        """0: where a motor stands says nothing of its gain."""
        return 0.0

    def stiffness_nm_per_rad(self, preset: ArrayLike) -> Floats:
        """Stiffness at presets 0 to 1 (any shape), N m/rad: proportional to the gain (ROBOTIS e-Manual, Position PID
        Gain).
        """
        return np.asarray(preset, dtype=np.float64) * self.full_preset

    def percent_for(self, stiffness_nm_per_rad: ArrayLike) -> Floats:
        """Percent of the full gain for stiffnesses in N m/rad (any shape). ScheduleError beyond what can be."""
        wanted = np.asarray(stiffness_nm_per_rad, dtype=np.float64)
        if not np.all((wanted >= 0) & (wanted <= self.full_preset * (1 + 1e-12))):
            text, asked = f"0 to {self.full_preset:.4g} N m/rad", f"{wanted.min():.4g} to {wanted.max():.4g}"
            do = "Ask for a stiffness that the joint can reach, or commission a larger full_gain."
            raise ScheduleError(f"stiffness of {self.name}", wanted=text, found=asked, do=do)
        return wanted * 100 / self.full_preset

    def rounded(self, preset: ArrayLike) -> Floats:
        """The nearest presets (any shape) that are whole gains, where the full gain is known."""
        given = np.asarray(preset, dtype=np.float64)
        return given if self.full_gain is None else np.asarray(np.rint(given * self.full_gain) / self.full_gain)


EXPORT = Export(
    lambda name, full_preset: GainJoint(full_preset, name=name),
    column="preset_nm_per_rad", unit="N m/rad", per_preset=1.0, whole=False,
    most=1000.0,
    remark="This project has tried no real Dynamixel motor: its driver is known to work with an emulated one only.",
)  # fmt: skip
"""Schedules state presets as the stiffness that they are."""
