"""What a rig is: gear, travel, device limits, loop and guards."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from emg2vsa.actuator import TICKS_PER_TURN
from emg2vsa.rig.force_sensor import ForceSample
from emg2vsa.rig.guards import GuardSettings


@dataclass(frozen=True)
class RigSettings:
    """One rig. Depth is the travel of the probe from its retracted position towards the specimen, mm."""

    gear_mm_per_degree: float = 0.2
    "Probe travel per degree of the output shaft."
    travel_mm: float = 15.0
    "As deep as the probe can go."
    home_ticks: int = 0
    "Position of the retracted probe."
    push_sign: Literal[1, -1] = 1
    "Whether more ticks push, or fewer."
    position_ticks: tuple[int, int] = (-12000, 12000)
    "Positions the actuator takes at every stiffness; read from the device."
    max_preset_ticks: int = 3000
    "Preset at full stiffness; read from the device."
    stiffness_percent: tuple[float, float] = (20.0, 80.0)
    "The study's range, percent of the maximum preset."
    push_axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    "Direction, in the sensor's axes, of the force that counts as pushing."
    rate_hz: float = 200.0
    filter_samples: int = 5
    "Moving average of the force that chooses phase and stiffness."
    escape_mm_per_s: float = 20.0
    "Speed of the retraction that ends every run; a guess below the 43 mm/s of a Maker Pro at this gear."
    settle_s: float = 0.3
    "From the last command of that retraction until the motors are switched off."
    guards: GuardSettings = field(default_factory=GuardSettings)

    @property
    def period_s(self) -> float:
        """Of the control loop."""
        return 1 / self.rate_hz

    def ticks_at(self, depth_mm: float) -> int:
        """Position for a depth, the nearest tick."""
        return self.home_ticks + round(self.push_sign * depth_mm / self._mm_per_tick)

    def depth_at(self, position_ticks: float) -> float:
        """Depth of a position, mm; below 0 behind the retracted position."""
        return (position_ticks - self.home_ticks) * self.push_sign * self._mm_per_tick

    def pushing_n(self, sample: ForceSample) -> float:
        """Force along ``push_axis``, N."""
        return float(np.dot(sample.force_n, self.push_axis))

    @property
    def _mm_per_tick(self) -> float:
        return self.gear_mm_per_degree * 360 / TICKS_PER_TURN
