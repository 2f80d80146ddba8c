"""A position gain as a spring: proportional, linear, and only as known as its stiffness."""

from __future__ import annotations

import math

import numpy as np
import pytest

from emg2vsa.devices.dynamixel.joint import EXPORT, GainJoint
from emg2vsa.devices.joints import joint_of
from emg2vsa.devices.protocols import Measurements
from emg2vsa.errors import ScheduleError

JOINT = GainJoint(4.0, full_gain=800)


def test_the_stiffness_is_proportional_to_the_gain() -> None:
    assert JOINT.stiffness_nm_per_rad([[0, 0.25], [0.5, 1]]).tolist() == [[0, 1], [2, 4]]


def test_presets_are_the_inverse_of_stiffnesses() -> None:
    presets = np.linspace(0, 1, 101)
    assert JOINT.percent_for(JOINT.stiffness_nm_per_rad(presets)) == pytest.approx(100 * presets, abs=1e-13)


@pytest.mark.parametrize("stiffness", [-0.001, 4.001, math.nan])
def test_a_stiffness_out_of_reach_is_refused(stiffness: float) -> None:
    with pytest.raises(ScheduleError, match=r"stiffness of dynamixel: expected 0 to 4 N m/rad"):
        JOINT.percent_for([1.0, stiffness])


def test_a_shaft_beyond_its_command_bears_a_positive_torque() -> None:
    beyond = Measurements((15.0,), 15.0)
    assert JOINT.torque_nm(beyond, 5.0, 0.5) == pytest.approx(2 * math.radians(10))
    assert JOINT.torque_nm(beyond, 16.0, 1.0) == pytest.approx(-4 * math.radians(1))
    assert JOINT.torque_nm(beyond, 5.0, 0.0) == 0


def test_the_motor_is_sent_nowhere_by_itself() -> None:
    assert JOINT.targets_deg(5.0, 0.5) == ()


def test_presets_are_rounded_to_whole_gains() -> None:
    rounded = JOINT.rounded([0, 0.0006, 0.0007, 0.5003, 1])
    assert (rounded * 800).tolist() == [0, 0, 1, 400, 800]
    assert JOINT.rounded(rounded).tolist() == rounded.tolist()


def test_without_a_device_at_hand_presets_stay_as_they_are() -> None:
    assert GainJoint(4.0).rounded([0.0006, 0.5003]).tolist() == [0.0006, 0.5003]


def test_where_a_motor_stands_says_nothing_of_its_gain() -> None:
    at = Measurements((15.0,), 15.0)
    assert (JOINT.position_deg(at), JOINT.preset_at(at)) == (15.0, 0.0)


def test_a_schedule_states_a_preset_as_the_stiffness_that_it_is() -> None:
    joint = joint_of("dynamixel", 21.0)
    assert (joint.name, joint.full_preset, joint.measured_key) == ("dynamixel", 21.0, "full_stiffness_nm_per_rad")
    assert EXPORT.exported(3.14159) == 3.14159
