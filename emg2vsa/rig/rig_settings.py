"""What a rig is: gear, travel, device limits, loop and guards, the table [rig] of rig.toml; and its devices."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import field
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, Literal

from emg2vsa.devices.device_settings import LOST_S, ActuatorSettings, CameraSettings, ForceSettings
from emg2vsa.devices.qbmove import MotorSettings
from emg2vsa.devices.qbmove.ticks import in_degrees
from emg2vsa.settings import Ge, Gt, Le, NonNegative, Positive
from emg2vsa.settings_class import settings_class

if TYPE_CHECKING:
    from emg2vsa.devices.protocols import ForceSample


@settings_class
class GuardSettings:
    """Limits beyond which a run ends, each with a bound that no rig file may pass. The paper gives none: where nothing
    is said of its source a value is a guess, to be set for each rig."""

    force_n: Annotated[float, Gt(0), Le(50)] = 10.0
    "Largest force along push_axis, of either sign, as measured and not filtered; above the F_max of 7 N."
    lateral_n: Annotated[float, Gt(0), Le(20)] = 3.0
    """Largest force across push_axis on the way in, beyond what the angle between probe and surface, and skin_friction,
    make of the force along it."""
    skin_friction: Annotated[float, Ge(0), Le(1)] = 0.6
    "Coefficient of friction between the probe's skin and the specimen to allow for; silicone has 0.4 to 1."
    torque_nm: Annotated[float, Gt(0), Le(5)] = 1.0
    "Largest torque on the force sensor."
    force_rate_n_per_s: Annotated[float, Gt(0), Le(3000)] = 300.0
    "Largest change of force; 5 mm/s into 20 N/mm is 100 N/s."
    stale_s: Annotated[float, Gt(0), Le(0.1)] = 0.025
    "Largest age of a force sample: five periods."
    frozen_mm: Annotated[float, Gt(0), Le(1)] = 0.18
    "How far the motors may press on while all six readings of the force sensor stay the same: 36 ms at 5 mm/s."
    frozen_s: Annotated[float, Gt(0), Le(2)] = 0.2
    "How long the readings may stay the same at rest, of a sensor that has shown that its own never do."
    spring_n: Annotated[float, Gt(0), Le(60)] = 12.0
    "Largest force on the probe by the deflection of the springs, whatever the force sensor says."
    spring_gap_n: Annotated[float, Gt(0), Le(20)] = 4.0
    """Largest difference between that force and the felt one, on the way in 2.5 N + 0.3 of the larger where
    that is less; friction and motion of the shaft make 2.8 N of it."""
    spring_rest_n: Annotated[float, Gt(0), Le(10)] = 1.5
    "Largest force by the springs with the stiffest springs, the probe free and at rest; friction makes 1 N of it."
    following_deg: Annotated[float, Gt(0), Le(6.6)] = 1.0986328125
    "How far a motor may be beyond its command, or behind a slow motor's way there: 0.22 mm at 0.2 mm per degree."
    following_s: Annotated[float, Gt(0), Le(0.2)] = 0.05
    "Time constant of that slow motor; the emulated Maker Pro, made after its firmware, has 0.033 s."
    following_deg_per_s: Annotated[float, Ge(32.9), Le(660)] = 131.8359375
    "Largest speed of that slow motor; a Maker Pro's is 215."
    current_a: Annotated[float, Gt(0), Le(6)] = 1.5
    "Largest mean current of a motor over ten turns; the limit that the device tells holds too."
    contact_mm: Annotated[float, Gt(0), Le(100)] = 6.0
    "Deepest place of the shaft at which contact may come."
    past_contact_mm: Annotated[float, Gt(0), Le(30)] = 10.0
    "How far the shaft may go on after contact; less where the stiffness of the specimen is known."
    camera_s: Annotated[float, Gt(0), Le(5)] = LOST_S
    "Longest time without a frame."
    late_s: Annotated[float, Gt(0), Le(0.1)] = 0.05
    "How late a turn of the loop may begin; the probe goes 0.25 mm meanwhile."
    specimen_share: Annotated[float, Gt(0), Le(1)] = 0.2
    """From 1 N on: how far the stiffness of the contact, of dome and specimen in series, may be off that of the named
    specimen, as a share. A dome of another dome_modulus_mpa, or a specimen that is no half-space, needs more."""
    motors_every_s: Annotated[float, Gt(0), Le(1)] = 0.1
    "How often the actuator is asked whether its motors are on; less than half of watchdog_s."


Doubtful = tuple[Annotated[float, Ge(0), Le(100)], Annotated[float, Ge(0), Le(100)]]
"""Percent beyond which a press is doubtful, and beyond which it is rejected."""


@settings_class
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


@settings_class
class RigSettings:
    """One rig. Depth is the travel of the probe from its retracted position towards the specimen, mm."""

    gear_mm_per_degree: Annotated[float, Ge(0.001), Le(100)] = 0.2
    "Probe travel per degree of the output shaft."
    travel_mm: Positive = 15.0
    "Way of the probe, as deep as it can go."
    home_deg: float = 0.0
    "Position of the retracted probe, an angle of the shaft."
    push_sign: Literal[1, -1] = 1
    "Whether larger angles push, or smaller ones."
    position_deg: tuple[float, float] = (-131.8359375, 131.8359375)
    "Positions the actuator may take; before a run narrowed to those the device takes at every stiffness."
    full_preset: Positive = 32.958984375
    """Preset at full stiffness. qbmove: degrees of each motor from their middle; the device's own is read before a run,
    and what both allow is kept. dynamixel: N m/rad; omitted: that of [actuator]."""
    stiffness_percent: tuple[NonNegative, Annotated[float, Gt(0), Le(100)]] = (20.0, 80.0)
    "The study's range, percent of the maximum preset."
    push_axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    "Direction, in the sensor's axes, of the force that counts as pushing."
    rate_hz: Annotated[float, Ge(50), Le(1000)] = 200.0
    "Turns of the control loop per second; four or more of them in watchdog_s."
    filter_samples: Annotated[int, Ge(1)] = 5
    "Moving average of the force that chooses phase and stiffness."
    dome_modulus_mpa: Positive = 0.4
    """Reduced modulus of the tactile sensor's dome, 20 mm in radius (guess). Every press tells the stiffness of its
    specimen by it: set it so that presses of a specimen of known stiffness tell that one in presses.csv."""
    dome_modulus_sd_percent: Annotated[float, Gt(0), Le(50)] = 3.0
    "Standard deviation of that, percent (guess: batch, temperature)."
    max_mm_per_s: Annotated[float, Gt(0), Le(200)] = 40.0
    "Largest speed of any motion; a Maker Pro at this gear makes 43 mm/s."
    escape_mm_per_s: Annotated[float, Ge(5), Le(200)] = 20.0
    "Speed of the retraction that ends every run."
    settle_s: Annotated[float, Ge(0), Le(2)] = 0.3
    "Time from the last command of that retraction until the motors are switched off."
    record_full_rate_force: bool = False
    "true: every record of the force sensor is kept in force-full-rate.csv, not only the newest of each turn."
    losses: LossSettings = field(default_factory=LossSettings)
    "How much of a press may be missing."
    guards: GuardSettings = field(default_factory=GuardSettings)
    "Limits beyond which a run ends."

    @cached_property
    def period_s(self) -> float:
        """Period of the control loop, s."""
        return 1 / self.rate_hz

    def position_at(self, depth_mm: float) -> float:
        """Position for a depth, degrees."""
        return self.home_deg + self.push_sign * depth_mm / self.gear_mm_per_degree

    def depth_at(self, position_deg: float) -> float:
        """Depth of a position, mm; below 0 behind the retracted position."""
        return (position_deg - self.home_deg) * self.push_sign * self._mm_per_turn / 360

    def pushing_n(self, sample: ForceSample) -> float:
        """Force along ``push_axis``, N."""
        fx, fy, fz = sample.loads[:3]
        x, y, z = self.push_axis
        return fx * x + fy * y + fz * z

    @cached_property
    def lever_m(self) -> float:
        """Travel of the probe per angle of the shaft, m/rad: the torque of the shaft over the force of the probe."""
        return math.degrees(self.gear_mm_per_degree) / 1000

    @cached_property
    def _mm_per_turn(self) -> float:
        # of 0.2 mm per degree exactly 72, so that depths of whole ticks are not rounded
        return self.gear_mm_per_degree * 360


def axis_of(rig: Mapping[str, Any]) -> RigSettings:
    """The rig of a plan.json as far as depth needs it. KeyError where it does not say."""
    found = in_degrees(rig)
    return RigSettings(**{name: found[name] for name in ("gear_mm_per_degree", "home_deg", "push_sign")})


@settings_class
class DeviceSettings:
    """All devices of a rig, each of the kind that its table in rig.toml names. motor : None without a rigid motor.
    camera : None where no frames are wanted."""

    actuator: ActuatorSettings
    force: ForceSettings
    motor: MotorSettings | None = None
    camera: CameraSettings | None = None
