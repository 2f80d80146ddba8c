"""Motor, gear and encoder: current makes torque, torque turns the shaft against load and friction.

The bridge gives a share of the supply (duty). Voltage that the turning motor makes counts against it, so that the
published stall current, stall torque and speed without load are a straight line. With the bridge off no current flows
(guess). A speed is found from the torques where the shaft is, then the angle from that speed (semi-implicit Euler),
which stays stable as long as the stiffest spring at the shaft turns it by less than 2 rad of phase in a step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from emg2vsa.worlds.far_ends.dynamixel.models import PULSES_PER_RAD, PULSES_PER_TURN, DynamixelModel

STEP_S = 1e-3
RATED_V = 12.0
UNSUPPLIED_V = 5.0
"""What the electronics still live on while the bridge no longer works (guess)."""


@dataclass
class MotorFaults:
    """What goes wrong, changed while the motor runs.

    jammed : the shaft does not move. unsupplied : the supply has broken down to 5 V. torque_nm : most that the motor
    can do; None is what it is built for. jumped_deg : added to what the encoder reads. current_ma : added to the
    measured current. flag_only : an expired watchdog tells so, and the motor goes on. deaf_watchdog : a write of Bus
    Watchdog is acknowledged and forgotten. supply_v, temperature_c : of the motor. hardware_error : bits of Hardware
    Error Status that have no cause here: 8 encoder, 16 electrical shock, 32 overload.
    """

    jammed: bool = False
    unsupplied: bool = False
    torque_nm: float | None = None
    jumped_deg: float = 0.0
    current_ma: float = 0.0
    flag_only: bool = False
    deaf_watchdog: bool = False
    supply_v: float = RATED_V
    temperature_c: float = 35.0
    hardware_error: int = 0


class Motor:
    """``angle_rad``, ``speed_rad_per_s``, ``current_a``: of the shaft, in the world's direction. ``duty``: of the
    supply that the model is rated for."""

    def __init__(self, model: DynamixelModel, home_deg: float) -> None:
        """``home_deg``: what the encoder reads with the shaft at 0."""
        self.model, self.faults = model, MotorFaults()
        self._home_rad = math.radians(home_deg)
        self._frozen: int | None = None
        self.angle_rad = self.speed_rad_per_s = self.current_a = self.duty = self.load_nm = 0.0

    @property
    def volts(self) -> float:
        """At the motor's plug."""
        return UNSUPPLIED_V if self.faults.unsupplied else self.faults.supply_v

    def freeze(self, frozen: bool) -> None:
        """The encoder stays as it is, or goes on."""
        self._frozen = self._pulses() if frozen else None

    def pulses(self) -> int:
        """What the encoder has counted; within a turn at a start."""
        jumped = round(self.faults.jumped_deg * PULSES_PER_TURN / 360)
        return (self._pulses() if self._frozen is None else self._frozen) + jumped

    def seen_rad_per_s(self) -> float:
        """Speed as the firmware takes it from the encoder; that it does so without error or delay is a guess."""
        return self.speed_rad_per_s if self._frozen is None else 0.0

    def step(self, on: bool, wanted_a: float | None, duty: float, most_duty: float) -> bool:
        """A step with a wanted current, or with a duty where that is None; True when the shaft stands still after it.

        ``most_duty``: of the supply, at most 1."""
        model, faults = self.model, self.faults
        emf = self.speed_rad_per_s / model.no_load_rad_per_s
        self.current_a = self.duty = 0.0
        if on and not faults.unsupplied:
            most_duty *= self.volts / RATED_V
            duty = duty if wanted_a is None else wanted_a / model.stall_current_a + emf
            self.duty = max(-most_duty, min(most_duty, duty))
            self.current_a = model.stall_current_a * (self.duty - emf)
        torque_nm = model.torque_constant_nm_per_a * self.current_a
        if faults.torque_nm is not None:
            torque_nm = max(-faults.torque_nm, min(faults.torque_nm, torque_nm))
        per_nm = STEP_S / (model.inertia_kg_m2 + STEP_S * model.viscous_nm_s)
        speed = per_nm * ((torque_nm - self.load_nm) + self.speed_rad_per_s * model.inertia_kg_m2 / STEP_S)
        held = per_nm * model.friction_nm
        speed = 0.0 if abs(speed) <= held or faults.jammed else speed - math.copysign(held, speed)
        self.speed_rad_per_s = speed
        self.angle_rad += speed * STEP_S
        return speed == 0

    def _pulses(self) -> int:
        return math.floor((self.angle_rad + self._home_rad) * PULSES_PER_RAD + 1e-9)
