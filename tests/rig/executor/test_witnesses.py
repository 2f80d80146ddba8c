"""Where a motor may be, from what it was told and when: far from there it stands still or runs away."""

from __future__ import annotations

import math

import pytest
from emg2vsa.actuator import SPRINGS

from emg2vsa.devices.protocols import Measurements
from emg2vsa.rig.executor.witnesses import DEAD_S, SlowMotors
from emg2vsa.rig.rig_settings import GuardSettings

AT = Measurements(100, -40, 30)
GUARDS = GuardSettings(following_s=0.05)


def slow_motors(rigid: bool = False) -> SlowMotors:
    return SlowMotors(AT, None if rigid else next(iter(SPRINGS.values())), GUARDS)


def test_before_any_command_no_motor_is_astray() -> None:
    assert slow_motors().astray_ticks(Measurements(900, -900, 0)) == 0.0


def test_between_where_it_was_and_its_command_a_motor_may_be_anywhere() -> None:
    motors = slow_motors()
    motors.send(1030, 70, 0.0)  # motors 1100 and 960
    for seen in (AT, Measurements(600, 500, 0), Measurements(1100, 960, 0)):
        assert motors.astray_ticks(seen) == 0.0
    assert motors.astray_ticks(Measurements(1107, 960, 0)) == 7.0
    assert motors.astray_ticks(Measurements(1100, -45, 0)) == 5.0


def test_a_motor_that_stands_still_falls_behind_a_follower_of_first_order() -> None:
    motors, step_s, told = slow_motors(), 0.001, 150
    for turn in range(51):
        motors.send(told, 70, step_s if turn else 0.0)  # motors 220 and 80: 120 to go
    followed_s = 50 * step_s - DEAD_S
    expected = 120 * (1 - math.exp(-followed_s / GUARDS.following_s))
    fastest_turn = 120 * step_s / GUARDS.following_s
    assert motors.astray_ticks(Measurements(100, 80, 0)) == pytest.approx(expected, abs=fastest_turn)
    assert motors.astray_ticks(Measurements(220, 80, 0)) == 0.0


def test_the_second_motor_of_a_rigid_actuator_is_not_asked() -> None:
    motors = slow_motors(rigid=True)
    motors.send(100, 0, 0.0)
    assert motors.astray_ticks(Measurements(100, 5000, 0)) == 0.0
    assert motors.astray_ticks(Measurements(90, 5000, 0)) == 10.0
