"""A position gain as a spring: proportional, linear, and only as known as its stiffness."""

from __future__ import annotations

import math

import numpy as np
import pytest

from emg2vsa.devices.dynamixel.joint import GainJoint
from emg2vsa.devices.protocols import Measurements
from emg2vsa.errors import ScheduleError

JOINT = GainJoint(full_gain=800, full_stiffness_nm_per_rad=4.0)


def test_the_stiffness_is_proportional_to_the_gain() -> None:
    assert JOINT.stiffness_nm_per_rad([[0, 0.25], [0.5, 1]]).tolist() == [[0, 1], [2, 4]]


def test_presets_are_the_inverse_of_stiffnesses() -> None:
    presets = np.linspace(0, 1, 101)
    assert JOINT.preset_for(JOINT.stiffness_nm_per_rad(presets)) == pytest.approx(presets, abs=1e-15)


@pytest.mark.parametrize("stiffness", [-0.001, 4.001, math.nan])
def test_a_stiffness_out_of_reach_is_refused(stiffness: float) -> None:
    with pytest.raises(ScheduleError, match=r"stiffness of the joint with gain 800: expected 0 to 4 N m/rad"):
        JOINT.preset_for([1.0, stiffness])


def test_a_shaft_beyond_its_command_bears_a_positive_torque() -> None:
    beyond = Measurements((15.0,), 15.0)
    assert JOINT.torque_nm(beyond, 5.0, 0.5) == pytest.approx(2 * math.radians(10))
    assert JOINT.torque_nm(beyond, 16.0, 1.0) == pytest.approx(-4 * math.radians(1))
    assert JOINT.torque_nm(beyond, 5.0, 0.0) == 0


def test_the_motor_is_sent_nowhere_by_itself() -> None:
    assert JOINT.targets_deg(5.0, 0.5) is None


def test_presets_are_rounded_to_whole_gains() -> None:
    rounded = JOINT.rounded([0, 0.0006, 0.0007, 0.5003, 1])
    assert (rounded * 800).tolist() == [0, 0, 1, 400, 800]
    assert JOINT.rounded(rounded).tolist() == rounded.tolist()


def test_without_a_measured_stiffness_there_is_no_torque_and_no_schedule() -> None:
    unknown = GainJoint(800, None)
    for ask in (unknown.stiffness_nm_per_rad, unknown.preset_for):
        with pytest.raises(ScheduleError, match=r"full_stiffness_nm_per_rad: expected the stiffness.*rig commission"):
            ask(0.5)
    with pytest.raises(ScheduleError, match="found none"):
        unknown.torque_nm(Measurements((0.0,), 0.0), 0.0, 1.0)
