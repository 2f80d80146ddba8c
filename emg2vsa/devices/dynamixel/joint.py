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
from emg2vsa.devices.dynamixel._interface import Measurements
from emg2vsa.errors import ScheduleError


@dataclass(frozen=True)
class GainJoint:
    """The stiffness is proportional to the gain.

    full_gain : whole gain at preset 1. full_stiffness_nm_per_rad : stiffness there; None until it has been measured.
    """

    full_gain: int
    full_stiffness_nm_per_rad: float | None

    def targets_deg(self, position_deg: float, preset: float) -> tuple[float, ...] | None:
        """None: the motor gives way itself, and does not stand at its command under load."""
        return None

    def torque_nm(self, at: Measurements, position_deg: float, preset: float) -> float:
        """External torque that the joint bears, N m; positive when the shaft is at a larger angle than commanded."""
        return self._full_nm_per_rad() * preset * math.radians(at.shaft_deg - position_deg)

    def stiffness_nm_per_rad(self, preset: ArrayLike) -> Floats:
        """Of presets 0 to 1 (any shape)."""
        return np.asarray(preset, dtype=np.float64) * self._full_nm_per_rad()

    def preset_for(self, stiffness_nm_per_rad: ArrayLike) -> Floats:
        """Presets of stiffnesses in N m/rad (any shape), not rounded. ScheduleError outside what the joint can do."""
        wanted, most = np.asarray(stiffness_nm_per_rad, dtype=np.float64), self._full_nm_per_rad()
        if not np.all((wanted >= 0) & (wanted <= most)):
            raise ScheduleError(
                f"stiffness of the joint with gain {self.full_gain}",
                wanted=f"0 to {most:.4g} N m/rad",
                found=f"{np.min(wanted):.4g} to {np.max(wanted):.4g}",
                do="Ask for a stiffness that the joint can reach, or commission a larger full_gain.",
            )
        return wanted / most

    def rounded(self, preset: ArrayLike) -> Floats:
        """The nearest preset that is a whole gain."""
        return np.asarray(np.rint(np.asarray(preset, dtype=np.float64) * self.full_gain) / self.full_gain)

    def _full_nm_per_rad(self) -> float:
        if self.full_stiffness_nm_per_rad is None:
            raise ScheduleError(
                "[actuator] full_stiffness_nm_per_rad",
                wanted="the stiffness at full_gain",
                found="none",
                do="Measure it: emg2vsa rig commission.",
            )
        return self.full_stiffness_nm_per_rad
