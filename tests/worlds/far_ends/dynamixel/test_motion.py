"""The motor gives way by torque over stiffness, does what its limits say, and stays stable."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any

import pytest

from emg2vsa.devices.clock import VirtualClock
from emg2vsa.worlds.bench.probe import WorldSettings
from emg2vsa.worlds.bench.world import World
from emg2vsa.worlds.contact import Relaxation
from emg2vsa.worlds.far_ends.dynamixel import table as t
from emg2vsa.worlds.far_ends.dynamixel.firmware import DynamixelFirmware
from emg2vsa.worlds.far_ends.dynamixel.table import (
    MODELS,
    PULSES_PER_RAD,
    XM430_W350,
    DynamixelModel,
)

LEVER_M = 0.5 * math.degrees(1) / 1000
"""Of a probe at 0.5 mm per degree."""
LOAD_NM = 7 * LEVER_M


@pytest.mark.parametrize("gain", [12, 100, 330, 800])
@pytest.mark.parametrize("sign", [1, -1])
def test_the_shaft_gives_way_by_torque_over_stiffness(desk: Callable[..., Any], gain: int, sign: int) -> None:
    """To the gear's friction and a pulse of the encoder."""
    one = desk()
    one.hold(gain)
    one.load_nm = lambda angle_rad: sign * LOAD_NM
    angle_rad = one.wait(3.0)[-1]
    stiffness = XM430_W350.stiffness_nm_per_rad(gain)
    tolerance_rad = XM430_W350.friction_nm / stiffness + 1 / PULSES_PER_RAD
    assert -sign * angle_rad == pytest.approx(LOAD_NM / stiffness, abs=tolerance_rad)


def test_stiffness_is_proportional_to_the_gain_and_spans_the_useful_range() -> None:
    low, high = XM430_W350.stiffness_nm_per_rad(12), XM430_W350.stiffness_nm_per_rad(330)
    assert high / low == pytest.approx(330 / 12)
    assert low == pytest.approx(0.3, abs=0.02)
    assert high == pytest.approx(8, abs=0.1)
    # robotis_op3 of google-deepmind/mujoco_menagerie: 21.1 N m/rad, in position mode at the default gain
    assert XM430_W350.stiffness_nm_per_rad(800) == pytest.approx(21.1, rel=0.1)


def test_the_mean_of_loading_and_unloading_has_no_friction_in_it(desk: Callable[..., Any]) -> None:
    """Slowly up and down again: half the sum of both ways is torque over stiffness, half the difference friction."""
    one = desk()
    one.hold(100)
    load = 0.0
    one.load_nm = lambda angle_rad: load
    ways: list[dict[int, float]] = [{}, {}]
    for way, steps in ((0, range(0, 41)), (1, range(39, 0, -1))):
        for step in steps:
            load = step * 0.01
            ways[way][step] = one.wait(0.4)[-1]
    stiffness = XM430_W350.stiffness_nm_per_rad(100)
    for step in (10, 20, 30):
        mean_rad, half_rad = (ways[0][step] + ways[1][step]) / 2, (ways[0][step] - ways[1][step]) / 2
        assert -mean_rad == pytest.approx(step * 0.01 / stiffness, abs=1 / PULSES_PER_RAD)
        assert half_rad == pytest.approx(XM430_W350.friction_nm / stiffness, abs=1 / PULSES_PER_RAD)


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_it_is_stable_at_all_gains_free_and_against_a_stiff_specimen(
    desk: Callable[..., Any], model: DynamixelModel
) -> None:
    """8 N/mm at 0.5 mm per degree are 6.5 N m/rad. What still moves after 3 s has died down further after 6 s, to no
    more than two pulses."""
    specimen = 8000 * LEVER_M**2
    for gain, damping, stiff in itertools.product((1, 800, 16383), (0, 16383), (False, True)):
        one = desk(model)
        one.hold(gain)
        one.write(t.POSITION_D, damping, 2)
        if stiff:
            one.load_nm = lambda angle_rad: max(0.0, specimen * (angle_rad - 0.1))
        one.write(t.GOAL_POSITION, 2348, 4)
        early, late = one.wait(3.0), one.wait(3.0)
        assert max(map(abs, early)) < 2 * 300 / PULSES_PER_RAD, (gain, damping)
        assert max(late[-60:]) - min(late[-60:]) <= 2 / PULSES_PER_RAD, (gain, damping, stiff)


def test_the_angle_does_not_depend_on_how_often_it_is_asked(desk: Callable[..., Any]) -> None:
    ends = []
    for period_s in (0.001, 0.005, 0.5):
        one = desk()
        one.hold(100)
        one.load_nm = lambda angle_rad: max(0.0, 6.5 * (angle_rad - 0.1))
        one.write(t.GOAL_POSITION, 2548, 4)
        ends.append(one.wait(1.0, period_s=period_s)[-1])
    assert ends[1] == pytest.approx(ends[0], abs=1e-4)
    assert ends[2] == pytest.approx(ends[0], abs=1e-4)


def hold_60(motor: DynamixelFirmware) -> None:
    motor.write(t.OPERATING_MODE, b"\x05")
    motor.write(t.POSITION_P, (60).to_bytes(2, "little"))
    motor.write(t.TORQUE_ENABLE, b"\x01")


def test_a_specimen_that_relaxes_lets_a_held_motor_on() -> None:
    ends = []
    for period_s in (0.005, 2.0):
        clock = VirtualClock()
        settings = WorldSettings(
            springs=None,
            mm_per_degree=0.5,
            gap_mm=2.0,
            stiffness_n_per_mm=8.0,
            plate=True,
            relaxation=Relaxation.of_share(0.5),
        )
        world = World(clock, settings)
        motor = DynamixelFirmware(XM430_W350, world, clock, home_deg=180.0, loads=world.loads_nm)
        hold_60(motor)
        motor.write(t.GOAL_POSITION, (2300).to_bytes(4, "little"))
        while clock.now_s() < 6:
            clock.sleep_until(clock.now_s() + period_s)
            motor.advance()
        ends.append(motor.angles_rad()[0])
    assert ends[1] == pytest.approx(ends[0], abs=1e-4)


def test_it_presses_a_specimen_of_the_emulated_world_through_its_own_compliance() -> None:
    """At rest the spring of the gain, the specimen and the friction are in balance."""
    clock = VirtualClock()
    world = World(
        clock,
        WorldSettings(springs=None, mm_per_degree=0.5, gap_mm=2.0, stiffness_n_per_mm=8.0, plate=True),
    )
    motor = DynamixelFirmware(XM430_W350, world, clock, home_deg=180.0, loads=world.loads_nm)
    hold_60(motor)
    stiffness, specimen = XM430_W350.stiffness_nm_per_rad(60), 8000 * LEVER_M**2
    for goal in (2048, 2090, 2120, 2200, 2300):
        motor.write(t.GOAL_POSITION, goal.to_bytes(4, "little"))
        for _ in range(200):
            clock.sleep_until(clock.now_s() + 0.005)
            motor.advance()
        turned_rad, touch_rad = (goal - 2048) / PULSES_PER_RAD, 2e-3 / LEVER_M
        pressed_rad = max(0.0, (turned_rad - touch_rad) * stiffness / (stiffness + specimen))
        tolerance_n = (XM430_W350.friction_nm + stiffness / PULSES_PER_RAD) / LEVER_M
        assert world.normal_force_n(clock.now_s()) == pytest.approx(pressed_rad * specimen / LEVER_M, abs=tolerance_n)
    assert world.normal_force_n(clock.now_s()) > 5


def test_without_torque_the_shaft_gives_way(desk: Callable[..., Any]) -> None:
    one = desk()
    one.hold(800)
    one.load_nm = lambda angle_rad: LOAD_NM
    assert abs(one.wait(1.0)[-1]) < 0.02
    one.write(t.TORQUE_ENABLE, 0, 1)
    assert one.wait(1.0)[-1] < -0.3
    assert one.read(t.PRESENT_CURRENT, 2) == 0
    stopped = desk()
    stopped.load_nm = lambda angle_rad: 0.9 * XM430_W350.friction_nm
    assert stopped.wait(1.0)[-1] == 0, "friction of the gear holds it"


def test_torque_on_goes_to_the_goal_that_was_written_before(desk: Callable[..., Any]) -> None:
    one = desk()
    one.write(t.OPERATING_MODE, 5, 1)
    one.write(t.GOAL_POSITION, 2248, 4)
    one.wait(0.2)
    assert one.read(t.PRESENT_POSITION, 4) == 2048
    one.write(t.TORQUE_ENABLE, 1, 1)
    one.wait(3.0)
    assert one.read(t.PRESENT_POSITION, 4) == pytest.approx(2248, abs=4)


def test_a_profile_takes_its_time_and_torque_off_ends_it(desk: Callable[..., Any]) -> None:
    one = desk()
    one.hold(2000)
    one.write(t.POSITION_D, 2000, 2)
    one.write(t.PROFILE_VELOCITY, 50, 4)
    one.write(t.GOAL_POSITION, 3048, 4)
    needed_s = 1000 / (50 * 0.229 * 4096 / 60)
    one.wait(needed_s / 2)
    assert one.read(t.PRESENT_VELOCITY, 4) == pytest.approx(50, abs=8)
    assert one.read(t.PRESENT_POSITION, 4) == pytest.approx(2548, abs=10)
    one.wait(needed_s / 2 - 0.05)
    assert one.read(t.PRESENT_POSITION, 4) < 3040
    one.wait(0.6)
    assert one.read(t.PRESENT_POSITION, 4) == pytest.approx(3048, abs=4)
    one.write(t.GOAL_POSITION, 1048, 4)
    one.wait(0.5)
    assert one.read(t.PRESENT_VELOCITY, 4, signed=True) == pytest.approx(-50, abs=8)
    one.write(t.TORQUE_ENABLE, 0, 1)
    one.wait(1.0)
    assert one.read(t.PRESENT_VELOCITY, 4) == 0


def test_a_command_is_known_after_the_latency_and_torque_on_waits_for_none(desk: Callable[..., Any]) -> None:
    one = desk(latency_s=0.05)
    one.hold(800, goal=2048)
    one.write(t.GOAL_POSITION, 2148, 4)
    assert one.read(t.GOAL_POSITION, 4) == 2148
    assert one.wait(0.045)[-1] == 0
    assert one.wait(0.1)[-1] > 0.05
    at_once = desk(latency_s=0.05)
    at_once.hold(800, goal=2148)
    assert at_once.wait(0.045)[-1] > 0.01


def test_a_derivative_gain_does_not_hold_a_profile_back(desk: Callable[..., Any]) -> None:
    one = desk()
    one.hold(500)
    one.write(t.POSITION_D, 4000, 2)
    one.write(t.PROFILE_VELOCITY, 50, 4)
    one.write(t.GOAL_POSITION, 3048, 4)
    one.wait(0.8)
    assert one.read(t.PRESENT_POSITION, 4) > 2048 + 0.8 * 50 * 0.229 * 4096 / 60 - 20


def test_a_lower_current_limit_binds_at_once(desk: Callable[..., Any]) -> None:
    one = desk()
    one.write(t.OPERATING_MODE, 5, 1)
    one.write(t.CURRENT_LIMIT, 50, 2)
    one.write(t.GOAL_POSITION, 3000, 4)
    one.write(t.TORQUE_ENABLE, 1, 1)
    one.load_nm = lambda angle_rad: 10.0
    one.motor.motor.faults.jammed = True
    one.wait(0.1)
    assert one.read(t.PRESENT_CURRENT, 2) == 50
