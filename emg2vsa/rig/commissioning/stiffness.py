"""Stiffness of a joint that nothing but a measurement tells: felt force over deflection, against the force sensor.

The probe presses a pad in small steps. The torque of the felt force over the angle by which the shaft stays behind its
command is the stiffness. A constant friction shifts that line and does not turn it, so its slope is taken. Friction
that varies, and the steps of the encoder, are errors of the angle and not of the force: the line is that of the angle
over the torque, as the other way round it would be too flat.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.errors import DeviceError
from emg2vsa.rig.commissioning.hand_motion import TOUCH_N, HandMotion
from emg2vsa.rig.rig_settings import RigSettings

_STEP_N = 0.25
"""Force that a step of the command adds, at most: of the stiffest joint on a pad that does not give way."""
_MOST_N = 5.0
"""And no more than half of the force limit."""
_LEAST_POINTS = 6
_MOST_STEPS = 200


class MeasuredStiffness(NamedTuple):
    """At one preset. se_nm_per_rad : standard error of the slope. points : of it."""

    preset: float
    nm_per_rad: float
    se_nm_per_rad: float
    points: int

    @property
    def full_nm_per_rad(self) -> float:
        """At the full preset, as stiffness is proportional to it."""
        return self.nm_per_rad / self.preset


def measure_stiffness(
    hand: HandMotion, rig: RigSettings, preset: float, from_deg: float, reach_deg: float, say: Callable[[str], None]
) -> MeasuredStiffness:
    """Press from ``from_deg``, where the probe is free, until 5 N are felt, and go back there.

    DeviceError : as `HandMotion`; no 5 N within ``reach_deg``, or a shaft that does not stay behind.
    """
    hand.soften(preset)
    most_n = min(_MOST_N, rig.guards.force_n / 2)
    touch = hand.go(from_deg + rig.push_sign * reach_deg, until_n=TOUCH_N)
    bent_deg, torque_nm = [], []
    step_deg = _step_deg(hand, rig, preset)
    for _ in range(_MOST_STEPS if touch.touched else 0):
        place = hand.go(hand.at_deg + rig.push_sign * step_deg, until_n=most_n)
        bent_deg.append(rig.push_sign * (hand.at_deg - place.shaft_deg))
        torque_nm.append(place.size_n * rig.lever_m)
        if place.size_n >= most_n:
            break
    else:
        hand.go(from_deg, from_zero=False)
        do = "Use a stiffer pad, or put it nearer."
        raise DeviceError("probe", wanted=f"{most_n:g} N within the reach", found="less", do=do)
    hand.go(from_deg, from_zero=False)
    found = _slope(np.radians(bent_deg), np.array(torque_nm), preset)
    said = f"{found.nm_per_rad:.3g} +- {found.se_nm_per_rad:.1g} N m/rad at {100 * preset:.3g} % of the full gain"
    say(f"stiffness: {said}, by {found.points} points")
    return found


def _step_deg(hand: HandMotion, rig: RigSettings, preset: float) -> float:
    """A step that adds `_STEP_N` where only the joint gives way."""
    joint = hand.joint
    assert joint is not None
    return math.degrees(_STEP_N * rig.lever_m / float(joint.stiffness_nm_per_rad(preset)))


def _slope(bent_rad: Floats, torque_nm: Floats, preset: float) -> MeasuredStiffness:
    if bent_rad.size < _LEAST_POINTS or np.ptp(bent_rad) <= 0:
        do = "Use a stiffer pad, and check that the rig file names the gain that the motor has."
        raise DeviceError(
            "probe", wanted="a shaft that stays behind its command", found=f"{bent_rad.size} points", do=do
        )
    (compliance, _), covariance = np.polyfit(torque_nm, bent_rad, 1, cov=True)
    se = math.sqrt(float(covariance[0, 0])) / float(compliance) ** 2
    return MeasuredStiffness(preset, 1 / float(compliance), se, bent_rad.size)
