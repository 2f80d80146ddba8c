"""Where a motor may be, from what it was told and when: far from there it stands still or runs away."""

from __future__ import annotations

import math

import pytest

from emg2vsa.devices.protocols import Measurements
from emg2vsa.devices.qbmove.springs import SpringJoint
from emg2vsa.rig.executor.witnesses import DEAD_S, SlowMotors
from emg2vsa.rig.rig_settings import GuardSettings

AT = Measurements((10.0, -4.0), 3.0)
GUARDS = GuardSettings(following_s=0.05)
JOINT = SpringJoint("qbmove-maker-pro", 40.0)


def slow_motors(rigid: bool = False) -> SlowMotors:
    return SlowMotors(AT, None if rigid else JOINT, GUARDS)


def test_before_any_command_no_motor_is_astray() -> None:
    assert slow_motors().astray_deg(Measurements((90.0, -90.0), 0.0)) == 0.0


def test_between_where_it_was_and_its_command_a_motor_may_be_anywhere() -> None:
    motors = slow_motors()
    motors.send(103.0, 7.0 / 40, 0.0)  # motors 110 and 96
    for seen in (AT, Measurements((60.0, 50.0), 0.0), Measurements((110.0, 96.0), 0.0)):
        assert motors.astray_deg(seen) == 0.0
    assert motors.astray_deg(Measurements((110.75, 96.0), 0.0)) == 0.75
    assert motors.astray_deg(Measurements((110.0, -4.5), 0.0)) == 0.5


def test_a_motor_that_stands_still_falls_behind_a_follower_of_first_order() -> None:
    motors, step_s, told = slow_motors(), 0.001, 4.2
    for turn in range(51):
        motors.send(told, 7.0 / 40, step_s if turn else 0.0)  # motors 11.2 and -2.8: 1.2 to go
    followed_s = 50 * step_s - DEAD_S
    expected = 1.2 * (1 - math.exp(-followed_s / GUARDS.following_s))
    fastest_turn = 1.2 * step_s / GUARDS.following_s
    assert motors.astray_deg(Measurements((10.0, -2.8), 0.0)) == pytest.approx(expected, abs=fastest_turn)
    assert motors.astray_deg(Measurements((11.2, -2.8), 0.0)) == pytest.approx(0.0, abs=1e-12)


def test_the_second_motor_of_a_rigid_actuator_is_not_asked() -> None:
    motors = slow_motors(rigid=True)
    motors.send(10.0, 0.0, 0.0)
    assert motors.astray_deg(Measurements((10.0, 500.0), 0.0)) == 0.0
    assert motors.astray_deg(Measurements((9.0, 500.0), 0.0)) == 1.0
