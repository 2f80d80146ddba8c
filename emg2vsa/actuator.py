"""The qbmove variable stiffness actuators: co-contraction to stiffness (7), motors to position and preset (8), springs.

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

from emg2vsa.arrays import Floats, Ints
from emg2vsa.errors import ScheduleError
from emg2vsa.settings import TICKS_PER_TURN

RAD_PER_TICK = 2 * math.pi / TICKS_PER_TURN
MOTOR_LIMIT_TICKS = 15000
"""Default position limit of each motor (164.8 degrees): no larger preset can be commanded."""
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


def stiffness_percent(activity_v: ArrayLike, span_v: tuple[float, float], percent: tuple[float, float]) -> Floats:
    """Equation (7), k = p1 v + p2: co-contraction v to percent of the actuator's maximum stiffness (any shape).

    span_v : the activities that go to the two ends of ``percent``; what lies outside goes to the nearer end.
    """
    share = np.clip((np.asarray(activity_v, dtype=np.float64) - span_v[0]) / (span_v[1] - span_v[0]), 0.0, 1.0)
    return (1 - share) * percent[0] + share * percent[1]


def equilibrium_and_preset(theta_1: float, theta_2: float) -> tuple[float, float]:
    """Equation (8): position (theta1 + theta2)/2 and preset (theta1 - theta2)/2 of two motors, in their unit."""
    return (theta_1 + theta_2) / 2, (theta_1 - theta_2) / 2


def motor_positions(equilibrium: int, preset: int) -> tuple[int, int]:
    """The motors theta1 and theta2 of an equilibrium and a preset: equation (8) the other way round."""
    return equilibrium + preset, equilibrium - preset


def ticks_of_percent(percent: ArrayLike, max_preset_ticks: int) -> Ints:
    """Percent of the maximum preset to whole ticks, the nearest."""
    return np.rint(np.asarray(percent, dtype=np.float64) / 100 * max_preset_ticks).astype(np.int64)


def stiffness_nm_per_rad(preset_ticks: ArrayLike, model: str) -> Floats:
    """Joint stiffness at zero load, N m/rad, of presets in ticks (any shape); the sign of a preset does not matter."""
    springs = SPRINGS[model]
    preset = np.abs(np.asarray(preset_ticks, dtype=np.float64)) * RAD_PER_TICK
    return stiffness_at(unloaded_deflection_rad(preset, springs), preset, springs)


def preset_for_stiffness(stiffness: ArrayLike, model: str) -> Floats:
    """Preset in ticks, not rounded, whose stiffness at zero load is ``stiffness`` in N m/rad (any shape).

    Inverse of ``stiffness_nm_per_rad`` by bisection, to the last digit of the stiffness. Near preset 0, where stiffness
    is flat, the preset itself is known to fewer digits. ScheduleError outside what the springs can do.
    """
    wanted = np.asarray(stiffness, dtype=np.float64)
    least, most = stiffness_nm_per_rad([0, MOTOR_LIMIT_TICKS], model)
    if not np.all((wanted >= least) & (wanted <= most)):
        raise ScheduleError(
            f"stiffness of {model}",
            wanted=f"{least:.4g} to {most:.4g} N m/rad at zero load",
            found=f"{np.min(wanted):.4g} to {np.max(wanted):.4g}",
            do="Ask for a stiffness that the springs can reach.",
        )
    low, high = np.zeros(wanted.shape), np.full(wanted.shape, float(MOTOR_LIMIT_TICKS))
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        below = stiffness_nm_per_rad(middle, model) < wanted
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return high


def unloaded_deflection_rad(preset_rad: Floats, springs: Springs) -> Floats:
    """Shaft position relative to x_e where the two springs balance, in rad, for presets >= 0.

    With a1 = a2 the balance is tanh(a d) = (k1 - k2)/(k1 + k2) tanh(a s); a few Newton steps on tau settle the rest.
    """
    k1, a1, k2, a2 = springs.k1_nm, springs.a1_per_rad, springs.k2_nm, springs.a2_per_rad
    mean_a = (a1 + a2) / 2
    deflection = np.arctanh((k1 - k2) / (k1 + k2) * np.tanh(mean_a * preset_rad)) / mean_a
    for _ in range(_NEWTON_STEPS):
        torque = k1 * np.sinh(a1 * (deflection - preset_rad)) + k2 * np.sinh(a2 * (deflection + preset_rad))
        deflection = deflection - torque / stiffness_at(deflection, preset_rad, springs)
    return deflection


def stiffness_at(deflection_rad: Floats, preset_rad: Floats, springs: Springs) -> Floats:
    """sigma, N m/rad, with the shaft ``deflection_rad`` away from x_e = (q1 + q2)/2."""
    return springs.a1_per_rad * springs.k1_nm * np.cosh(
        springs.a1_per_rad * (deflection_rad - preset_rad)
    ) + springs.a2_per_rad * springs.k2_nm * np.cosh(springs.a2_per_rad * (deflection_rad + preset_rad))
