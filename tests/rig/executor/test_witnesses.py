"""The motion of a run: its witnesses, and the moving average that decides."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.signal import freqz, group_delay

from emg2vsa.devices.protocols import Measurements
from emg2vsa.devices.qbmove.springs import SpringJoint
from emg2vsa.rig.executor.motion import MovingAverage
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


def test_it_is_the_mean_of_the_last_samples():
    average = MovingAverage(3, 200)
    assert [average.update(value) for value in (3, 5, 10, 0, 2)] == [3, 4, 6, 5, 4]


def test_no_rounding_stays_behind_and_no_nan():
    average = MovingAverage(2, 200)
    for value in (1e16, math.nan, 1.0):
        average.update(value)
    assert average.update(3.0) == 2.0


def test_the_papers_filter_is_18_hz_and_10_ms():
    average = MovingAverage(5, 200)
    assert average.cutoff_hz == pytest.approx(18.0, abs=0.2)
    assert average.delay_s == pytest.approx(0.010)
    assert average.description == "mean of 5 samples at 200 Hz: -3 dB at 18 Hz, delay 10 ms"


def test_5_hz_needs_18_samples():
    assert MovingAverage(18, 200).cutoff_hz == pytest.approx(5, abs=0.1)


@pytest.mark.parametrize("n", [2, 3, 5, 18, 100])
def test_cut_off_and_delay_against_scipy(n):
    average = MovingAverage(n, 200)
    taps = np.ones(n) / n
    _, response = freqz(taps, worN=[average.cutoff_hz], fs=200)
    assert abs(response[0]) == pytest.approx(math.sqrt(0.5), rel=1e-9)
    _, delay = group_delay((taps, [1.0]), w=[average.cutoff_hz / 2], fs=200)
    assert average.delay_s * 200 == pytest.approx(delay[0])


def test_one_sample_is_no_filter():
    average = MovingAverage(1, 200)
    assert (average.cutoff_hz, average.delay_s) == (math.inf, 0)
    assert average.description.startswith("no filter")
