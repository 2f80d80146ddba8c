"""What a rig is: gear, travel, device limits, loop and guards; the table [rig] of rig.toml."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any, Literal

from emg2vsa.rig.device_settings import LOST_S
from emg2vsa.settings import TICKS_PER_TURN, Ge, Gt, Le, NonNegative, Positive

if TYPE_CHECKING:
    from emg2vsa.rig.devices import ForceSample


@dataclass(frozen=True)
class GuardSettings:
    """Limits beyond which a run ends. All but force_n are guesses, to be set for each rig; the paper gives none."""

    force_n: Positive = 10.0
    "Largest force, of either sign, as measured and not filtered; above the F_max of 7 N."
    force_rate_n_per_s: Positive = 300.0
    "Largest change of force; 5 mm/s into 20 N/mm is 100 N/s."
    stale_s: Positive = 0.025
    "Largest age of a force sample: five periods."
    camera_s: Positive = LOST_S
    "Longest time without a frame."
    late_s: Positive = 0.05
    "How late a turn of the loop may begin; the probe goes 0.25 mm meanwhile."
    motors_every_s: Positive = 0.1
    "How often the actuator is asked whether its motors are on."


Doubtful = tuple[Annotated[float, Ge(0), Le(100)], Annotated[float, Ge(0), Le(100)]]
"""Percent beyond which a press is doubtful, and beyond which it is rejected."""


@dataclass(frozen=True)
class LossSettings:
    """How much of a press may be missing: two percentages, beyond which it is doubtful, and beyond which rejected."""

    late_turns_percent: Doubtful = (1.0, 50.0)
    "Turns of the loop that began half a period or more after their time."
    missing_turns_percent: Doubtful = (1.0, 20.0)
    "Turns that never were: rows that log.csv has fewer than rate_hz promises."
    lost_force_percent: Doubtful = (1.0, 20.0)
    "Records of the force sensor that never came, or too late."
    missing_frames_percent: Doubtful = (5.0, 20.0)
    "Frames between the first and the last of the press."


@dataclass(frozen=True)
class RigSettings:
    """One rig. Depth is the travel of the probe from its retracted position towards the specimen, mm."""

    gear_mm_per_degree: Positive = 0.2
    "Probe travel per degree of the output shaft."
    travel_mm: Positive = 15.0
    "As deep as the probe can go."
    home_ticks: int = 0
    "Position of the retracted probe."
    push_sign: Literal[1, -1] = 1
    "Whether more ticks push, or fewer."
    position_ticks: tuple[int, int] = (-12000, 12000)
    "Positions the actuator may take; before a run narrowed to those the device takes at every stiffness."
    max_preset_ticks: Annotated[int, Gt(0)] = 3000
    "Preset at full stiffness; the device's own is read before a run, and what both allow is kept."
    stiffness_percent: tuple[NonNegative, Annotated[float, Gt(0), Le(100)]] = (20.0, 80.0)
    "The study's range, percent of the maximum preset."
    push_axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    "Direction, in the sensor's axes, of the force that counts as pushing."
    rate_hz: Annotated[float, Gt(0), Le(1000)] = 200.0
    "Turns of the control loop per second."
    filter_samples: Annotated[int, Ge(1)] = 5
    "Moving average of the force that chooses phase and stiffness."
    escape_mm_per_s: Positive = 20.0
    "Speed of the retraction that ends every run; a guess below the 43 mm/s of a Maker Pro at this gear."
    settle_s: NonNegative = 0.3
    "From the last command of that retraction until the motors are switched off."
    record_full_rate_force: bool = False
    "true: every record of the force sensor is kept in force.csv of the run, not only the newest of each turn."
    losses: LossSettings = field(default_factory=LossSettings)
    "How much of a press may be missing."
    guards: GuardSettings = field(default_factory=GuardSettings)
    "Limits beyond which a run ends."

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
        return float(sample.force_n.dot(self.push_axis))

    @property
    def _mm_per_tick(self) -> float:
        return self.gear_mm_per_degree * 360 / TICKS_PER_TURN


def axis_of(rig: Mapping[str, Any]) -> RigSettings:
    """The rig of a plan.json as far as depth needs it. KeyError where it does not say."""
    return RigSettings(**{name: rig[name] for name in ("gear_mm_per_degree", "home_ticks", "push_sign")})
