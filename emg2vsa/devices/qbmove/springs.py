"""The springs of the qbmove variable stiffness actuators: motors to position and preset (8), presets to stiffness.

Two motors at q1 = x_e + s and q2 = x_e - s pull the output shaft x through exponential springs; s is the preset, the
co-contraction of equation (8). The external torque that holds the shaft at x, and the stiffness there, are

    tau(x)   = k1 sinh(a1 (x - q1)) + k2 sinh(a2 (x - q2))
    sigma(x) = a1 k1 cosh(a1 (x - q1)) + a2 k2 cosh(a2 (x - q2))

Stiffness is stated at zero load, that is at the shaft position where tau = 0. Since k1 and k2 differ, that is not
x_e = (q1 + q2)/2 (docs/decisions/0004-stiffness-at-zero-load.md).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats
from emg2vsa.devices.joints import Export
from emg2vsa.devices.protocols import Measurements
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK, TICKS_PER_TURN, to_ticks
from emg2vsa.errors import ScheduleError

RAD_PER_TICK = 2 * math.pi / TICKS_PER_TURN
MOTOR_LIMIT_TICKS = 15000
"""Default position limit of each motor (164.8 degrees): no larger preset can be commanded."""
_PRESET_TICKS_PER_S = 8000
"""To the stiff springs of the rest before the first press and back; twice as fast, motors fall behind the guard's."""
_WHOLE = 1e-6
_NEWTON_STEPS = 8
_HALVINGS = 64


@dataclass(frozen=True)
class Springs:
    """The two springs of a joint: k in N m, a in 1/rad."""

    k1_nm: float
    a1_per_rad: float
    k2_nm: float
    a2_per_rad: float
    source: str


SPRINGS = {
    "qbmove-advanced": Springs(0.0026, 8.9995, 0.0011, 8.9989, "qbmove Advanced Kit manual, 28 April 2021, page 15"),
    "qbmove-maker-pro": Springs(
        0.0227, 6.7328, 0.0216, 6.9602, "qbmove Maker Pro datasheet, as in NMMI/ILC-code, Parameters/cube_parameters.m"
    ),
}


class SpringJoint:
    """A joint of two motors and two springs. Its own unit of a preset is the degree of a motor from their middle.

    name : "qbmove-maker-pro" or "qbmove-advanced". full_preset : degrees, whole ticks.
    """

    measured_key = None
    settles_s = 0.0

    def __init__(self, name: str, full_preset: float) -> None:
        self.name, self.full_preset, self.springs = name, full_preset, SPRINGS[name]
        self.full_ticks = to_ticks(full_preset)
        self.preset_per_s = _PRESET_TICKS_PER_S / self.full_ticks

    def targets_deg(self, position_deg: float, preset: float) -> tuple[float, float]:
        """Equation (8) the other way round: theta1 and theta2, degrees, of an equilibrium, degrees, and a preset."""
        apart_deg = preset * self.full_preset
        return position_deg + apart_deg, position_deg - apart_deg

    def torque_nm(self, at: Measurements, position_deg: float = 0.0, preset: float = 0.0) -> float:
        """As `Joint`, N m: by where motors and shaft are, whatever is commanded."""
        springs, (first_deg, second_deg) = self.springs, at.motors_deg
        first, second = math.radians(at.shaft_deg - first_deg), math.radians(at.shaft_deg - second_deg)
        return springs.k1_nm * _sinh(springs.a1_per_rad * first) + springs.k2_nm * _sinh(springs.a2_per_rad * second)

    def position_deg(self, at: Measurements) -> float:
        """Equation (8): (theta1 + theta2)/2, degrees."""
        return (at.motors_deg[0] + at.motors_deg[1]) / 2

    def preset_at(self, at: Measurements) -> float:
        """Equation (8): (theta1 - theta2)/2 over the full preset."""
        return (at.motors_deg[0] - at.motors_deg[1]) / 2 / self.full_preset

    def stiffness_nm_per_rad(self, preset: ArrayLike) -> Floats:
        """At zero load, N m/rad, of presets of any shape (springs: manual and data sheet of the qbmove); their sign
        does not matter."""
        preset_rad = np.abs(self.preset_rad(preset))
        return stiffness_at(unloaded_deflection_rad(preset_rad, self.springs), preset_rad, self.springs)

    def percent_for(self, stiffness_nm_per_rad: ArrayLike) -> Floats:
        """Presets, percent, of stiffnesses in N m/rad at zero load, of any shape.

        By bisection, to the last digit of the stiffness. Near preset 0, where stiffness is flat, the preset is known to
        fewer digits.
        ScheduleError : a stiffness that the springs cannot reach.
        """
        wanted = np.asarray(stiffness_nm_per_rad, dtype=np.float64)
        least, most = self.stiffness_nm_per_rad(np.array([0, MOTOR_LIMIT_TICKS]) / self.full_ticks)
        if not np.all((wanted >= least) & (wanted <= most)):
            asked, do = (
                f"{np.min(wanted):.4g} to {np.max(wanted):.4g}",
                "Ask for a stiffness that the springs can reach.",
            )
            text = f"{least:.4g} to {most:.4g} N m/rad at zero load"
            raise ScheduleError(f"stiffness of {self.name}", wanted=text, found=asked, do=do)
        low, high = np.zeros(wanted.shape), np.full(wanted.shape, float(MOTOR_LIMIT_TICKS))
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            preset_rad = middle * RAD_PER_TICK
            below = stiffness_at(unloaded_deflection_rad(preset_rad, self.springs), preset_rad, self.springs) < wanted
            low, high = np.where(below, middle, low), np.where(below, high, middle)
        return high * 100 / self.full_ticks

    def rounded(self, preset: ArrayLike) -> Floats:
        """The nearest presets (any shape) that are whole ticks."""
        return np.asarray(np.rint(np.asarray(preset, dtype=np.float64) * self.full_ticks) / self.full_ticks)

    def preset_rad(self, preset: ArrayLike) -> Floats:
        """Angle of each motor from their middle, rad, of presets of any shape; whole ticks are whole, however their
        share was rounded."""
        ticks = np.asarray(preset, dtype=np.float64) * self.full_ticks
        whole = np.rint(ticks)
        return np.asarray(np.where(np.abs(ticks - whole) < _WHOLE, whole, ticks) * RAD_PER_TICK)


def unloaded_deflection_rad(preset_rad: Floats, springs: Springs) -> Floats:
    """Shaft position relative to x_e where the two springs balance, in rad, for presets >= 0.

    With a1 = a2 the balance is tanh(a d) = (k1 - k2)/(k1 + k2) tanh(a s); a few Newton steps on tau settle the rest.
    Springs: manual and data sheet of the qbmove.
    """
    k1, a1, k2, a2 = springs.k1_nm, springs.a1_per_rad, springs.k2_nm, springs.a2_per_rad
    mean_a = (a1 + a2) / 2
    deflection = np.arctanh((k1 - k2) / (k1 + k2) * np.tanh(mean_a * preset_rad)) / mean_a
    for _ in range(_NEWTON_STEPS):
        torque = k1 * np.sinh(a1 * (deflection - preset_rad)) + k2 * np.sinh(a2 * (deflection + preset_rad))
        deflection = deflection - torque / stiffness_at(deflection, preset_rad, springs)
    return deflection


def stiffness_at(deflection_rad: Floats, preset_rad: Floats, springs: Springs) -> Floats:
    """sigma, N m/rad, with the shaft ``deflection_rad`` away from x_e = (q1 + q2)/2. Springs: manual and data sheet of
    the qbmove."""
    return springs.a1_per_rad * springs.k1_nm * np.cosh(
        springs.a1_per_rad * (deflection_rad - preset_rad)
    ) + springs.a2_per_rad * springs.k2_nm * np.cosh(springs.a2_per_rad * (deflection_rad + preset_rad))


def _sinh(x: float) -> float:
    # encoders that have lost their turns may be anywhere
    return math.sinh(max(-100.0, min(100.0, x)))


EXPORT = Export(SpringJoint, "preset_ticks", "ticks", 1 / DEG_PER_TICK, whole=True, most=MOTOR_LIMIT_TICKS)
"""Schedules for a qbmove state presets in its ticks."""
