"""The shared world: force over motors, time in steps of any size, devices that ask at times of their own."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from casr.specimens import SPECIMENS
from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.qbmove.driver import Qbmove
from emg2vsa.devices.qbmove.springs import RAD_PER_TICK, SPRINGS
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK
from emg2vsa.devices.serial_line import LoopbackLine
from emg2vsa.errors import DeviceError
from emg2vsa.worlds.bench.probe import WorldSettings
from emg2vsa.worlds.bench.world import ShaftPath, World
from emg2vsa.worlds.far_ends.qbmove.firmware import QbmoveFirmware
from emg2vsa.worlds.far_ends.qbmove.memory import MAKER_PRO

SPEED_RAD_PER_S = 0.5
"About 5 mm/s through the gear."


def world(**settings: Any) -> World:
    return World(VirtualClock(), WorldSettings(**settings))


def motors(position: float, preset_ticks: int) -> tuple[float, float]:
    preset = preset_ticks * RAD_PER_TICK
    return position + preset, position - preset


def pressed(preset_ticks: int = 1500, *, turns_s: float = 2.0, step_s: float = 0.005, **settings: Any) -> list[float]:
    """Normal force each 50 ms of a press."""
    it, forces = world(**settings), []
    every = round(0.05 / step_s)
    for k in range(round(turns_s / step_s) + 1):
        it.shaft_rad(k * step_s, motors(SPEED_RAD_PER_S * k * step_s, preset_ticks))
        if k % every == 0:
            forces.append(it.normal_force_n(k * step_s))
    return forces


@pytest.mark.parametrize("springs", SPRINGS.values(), ids=SPRINGS)
@pytest.mark.parametrize("preset_ticks", [600, 1500, 2400])
def test_the_further_the_motors_the_higher_the_force(springs: Any, preset_ticks: int) -> None:
    forces = pressed(preset_ticks, springs=springs, turns_s=2.5)
    assert forces[0] == 0.0
    assert forces[-1] > 5
    touched = [force for force in forces if force > 0]
    assert np.all(np.diff(touched) > 0)
    assert len(touched) > 20


def test_a_stiffer_preset_presses_harder_at_equal_position() -> None:
    ends = [pressed(ticks)[-1] for ticks in (0, 600, 1200, 1800, 2400)]
    assert np.all(np.diff(ends) > 0.1)
    assert ends[-1] < pressed(0, springs=None)[-1]


def test_a_stiffening_preset_presses_harder_while_the_position_stays() -> None:
    it = world()
    it.shaft_rad(0.0, motors(0.8, 600))
    it.shaft_rad(1.0, motors(0.8, 600))
    soft_n = it.normal_force_n(1.0)
    it.shaft_rad(1.1, motors(0.8, 2400))
    assert it.normal_force_n(2.0) > 1.2 * soft_n > 0


@pytest.mark.parametrize("springs", [*SPRINGS.values(), None], ids=[*SPRINGS, "rigid"])
def test_steps_of_1_and_5_ms_agree(springs: Any) -> None:
    fine, coarse = (np.array(pressed(springs=springs, step_s=step_s)) for step_s in (0.001, 0.005))
    np.testing.assert_allclose(coarse, fine, rtol=1e-6, atol=1e-9)
    # steps that are not a whole number of milliseconds
    odd = pressed(springs=springs, step_s=0.05 / 18)
    np.testing.assert_allclose(odd[: len(fine)], fine[: len(odd)], rtol=0.01, atol=1e-3)


@pytest.mark.parametrize("angle_deg", [0.0, 45.0])
def test_nothing_drifts_at_rest(angle_deg: float) -> None:
    it = world(angle_deg=angle_deg)
    at = motors(0.9, 1500)
    it.shaft_rad(0.0, motors(0.0, 1500))
    it.shaft_rad(0.5, at)
    shaft, force = it.shaft_rad(2.0, at), it.normal_force_n(2.0)
    assert force > 1
    for time_s in (2.001, 2.5, 60.0, 600.0, 36000.0):
        assert it.shaft_rad(time_s, at) == shaft
        assert it.normal_force_n(time_s) == force


@pytest.mark.parametrize("springs", [*SPRINGS.values(), None], ids=[*SPRINGS, "rigid"])
def test_a_retracted_probe_feels_exactly_nothing(springs: Any) -> None:
    it = world(springs=springs, angle_deg=30.0)
    it.shaft_rad(0.0, motors(0.0, 1500))
    it.shaft_rad(2.0, motors(1.0, 1500))
    assert it.force_n(2.0)[2] > 1
    it.shaft_rad(2.4, motors(0.0, 1500))
    assert it.force_n(2.6).tolist() == [0.0, 0.0, 0.0]
    assert it.normal_force_n(2.6) == 0.0


@pytest.mark.parametrize("springs", SPRINGS.values(), ids=SPRINGS)
def test_no_motors_within_their_limits_break_it(springs: Any) -> None:
    it = world(springs=springs, angle_deg=45.0)
    rng = np.random.default_rng(5)
    for k in range(300):
        first, second = rng.uniform(-15000, 15000, 2) * RAD_PER_TICK
        shaft = it.shaft_rad(k * 0.01, (float(first), float(second)))
        assert math.isfinite(shaft)
        assert abs(shaft) < 4
        assert np.isfinite(it.force_n(k * 0.01)).all()


def test_the_first_motors_find_the_shaft_at_rest() -> None:
    it = world()
    start = it.shaft_rad(0.0, motors(0.3, 1500))
    assert start == pytest.approx(0.3, abs=0.01)
    assert it.shaft_rad(1.0, motors(0.3, 1500)) == start


def test_before_any_motors_the_probe_hangs_at_0() -> None:
    it = world()
    it.force_n(1.0)
    assert (it.probe_mm(1.5), it.normal_force_n(2.0)) == (0.0, 0.0)


def test_the_past_is_answered_and_changes_nothing() -> None:
    asked, other = world(), world()
    past = []
    for k in range(401):
        for it in (asked, other):
            it.shaft_rad(k * 0.005, motors(SPEED_RAD_PER_S * k * 0.005, 1500))
        past.append(asked.normal_force_n(k * 0.005))
        asked.force_n(k * 0.0025)
    assert [asked.normal_force_n(k * 0.005) for k in range(401)] == past
    assert other.probe_mm(2.0) == asked.probe_mm(2.0)


def test_between_steps_the_shaft_moves_evenly() -> None:
    it = world(springs=None)
    it.shaft_rad(0.0, (0.0, 0.0))
    it.shaft_rad(1.0, (1.0, 0.0))
    for time_s in (0.0, 0.25, 0.3337, 1.0):
        assert it.probe_mm(time_s) == pytest.approx(time_s * math.degrees(0.2))


def test_a_step_of_a_rounding_error_is_a_step() -> None:
    it = world()
    it.shaft_rad(0.3, motors(0.3, 1500))
    assert it.probe_mm(math.nextafter(0.3, 1)) == it.probe_mm(0.3) > 0


def test_time_that_has_passed_takes_new_motors_from_then_on() -> None:
    it = world(springs=None)
    it.shaft_rad(0.0, (0.0, 0.0))
    it.force_n(1.0)
    assert it.shaft_rad(0.9, (1.0, 0.0)) == 0.0
    assert it.shaft_rad(1.001, (1.0, 0.0)) == 1.0


@pytest.mark.parametrize("ask_s", [0.001, 0.005])
def test_a_real_firmware_presses_and_lets_go(ask_s: float) -> None:
    clock = VirtualClock()
    it = World(clock, WorldSettings(stiffness_n_per_mm=SPECIMENS["S5"]))
    firmware = QbmoveFirmware(MAKER_PRO, it, clock)
    qbmove = Qbmove(LoopbackLine("bench", firmware, clock), 1, clock=clock)

    def after(seconds: float) -> float:
        for _ in range(round(seconds / ask_s)):
            clock.sleep_until(clock.now_s() + ask_s)
            qbmove.measurements()
        return it.normal_force_n(clock.now_s())

    with qbmove:
        qbmove.activate()
        qbmove.command(4500 * DEG_PER_TICK, 0.5)
        # balance with the motors at 6000 and 3000 ticks, near which they stop, and friction still to be overcome
        assert after(2.0) == pytest.approx(6.42, rel=0.01)
        shaft = qbmove.ticks().shaft
        # the load bends the springs back
        assert shaft == pytest.approx(4113, abs=16)
        assert it.probe_mm(clock.now_s()) == pytest.approx(shaft * DEG_PER_TICK * 0.2, abs=0.016)
        qbmove.command(0.0, 0.5)
        assert after(2.0) == 0.0


def test_motion_is_straight_between_points_and_rest_is_flat() -> None:
    path = ShaftPath(0.0, 0.0)
    for time_s, angle_rad in ((1.0, 0.5), (2.0, 0.5), (4.0, 0.5), (5.0, 0.1)):
        path.append(time_s, angle_rad)
    times_s = (0.0, 0.5, 1.0, 1.5, 3.0, 4.0, 4.5, 5.0)
    expected = [0.0, 0.25, 0.5, 0.5, 0.5, 0.5, 0.3, 0.1]
    assert [path.angle_rad(time_s) for time_s in times_s] == pytest.approx(expected)
    assert (path.end_s, path.end_rad) == (5.0, 0.1)


def test_a_rest_of_any_length_is_remembered() -> None:
    path = ShaftPath(0.0, 0.2)
    for k in range(1, 200_000):
        path.append(k * 0.001, 0.7)
    assert path.angle_rad(0.0005) == pytest.approx(0.45)


def test_a_minute_of_motion_is_remembered_and_not_much_more() -> None:
    path = ShaftPath(0.0, 0.0)
    for k in range(1, 200_001):
        path.append(k * 0.001, k * 0.001)
    assert path.angle_rad(140.0005) == pytest.approx(140.0005)
    said = r"emulated world: expected a time from 1\d\d\.\d\d\d s on, but found 60\.000 s"
    with pytest.raises(DeviceError, match=said):
        path.angle_rad(60.0)
