"""The shaft between springs, specimen and friction."""

from __future__ import annotations

import math

import numpy as np
import pytest

from emg2vsa.devices.joints import joint_of
from emg2vsa.devices.qbmove.springs import RAD_PER_TICK, SPRINGS, unloaded_deflection_rad
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK
from emg2vsa.worlds.bench.actuator_joint import RigidJoint, SpringJoint
from emg2vsa.worlds.bench.probe import Probe, WorldSettings

LIMIT_RAD = 15000 * RAD_PER_TICK
FREE = Probe(WorldSettings(gap_mm=1e6))
S3 = Probe(WorldSettings())
MODELS = sorted(SPRINGS)


def rest(model: str, motors: tuple[float, float], probe: Probe, friction_nm: float = 0.0, start: float = 0.0) -> float:
    return SpringJoint(SPRINGS[model], friction_nm, 0.01).moved(start, math.inf, motors, probe)


def stiffness_nm_per_rad(ticks: float, model: str) -> float:
    return float(joint_of(model, 3000 * DEG_PER_TICK).stiffness_nm_per_rad(ticks / 3000))


def held_nm(model: str, shaft: float, motors: tuple[float, float], probe: Probe) -> float:
    s, (first, second) = SPRINGS[model], motors
    springs_nm = s.k1_nm * math.sinh(s.a1_per_rad * (shaft - first)) + s.k2_nm * math.sinh(
        s.a2_per_rad * (shaft - second)
    )
    return springs_nm + probe.torque_nm(shaft)[0]


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("preset", [0.0, 0.1, 0.5, 1.0])
def test_without_load_the_shaft_rests_where_the_springs_balance(model: str, preset: float) -> None:
    expected = 0.3 + float(unloaded_deflection_rad(np.float64(preset), SPRINGS[model]))
    assert rest(model, (0.3 + preset, 0.3 - preset), FREE) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("model", MODELS)
def test_a_little_load_gives_way_by_the_stiffness_of_the_preset(model: str) -> None:
    for ticks in (600, 1500, 2400):
        preset = ticks * RAD_PER_TICK
        # the motors stand so that the free shaft is at first contact
        free = float(unloaded_deflection_rad(np.float64(preset), SPRINGS[model]))
        centre = S3.touch_rad - free + 1e-4
        shaft = rest(model, (centre + preset, centre - preset), S3)
        load_nm = S3.torque_nm(shaft)[0]
        assert load_nm > 0
        stiffness = stiffness_nm_per_rad(ticks, model)
        assert load_nm / (S3.touch_rad + 1e-4 - shaft) == pytest.approx(stiffness, rel=1e-3)


@pytest.mark.parametrize("friction_nm", [0.0, 0.01])
@pytest.mark.parametrize("model", MODELS)
def test_any_motors_within_their_limits_find_a_rest(model: str, friction_nm: float) -> None:
    for first in np.linspace(-LIMIT_RAD, LIMIT_RAD, 13):
        for second in np.linspace(-LIMIT_RAD, LIMIT_RAD, 13):
            motors = (float(first), float(second))
            for start in (-3.0, 0.0, 3.0):
                shaft = rest(model, motors, S3, friction_nm, start)
                growth_nm = held_nm(model, shaft + 1e-8, motors, S3) - held_nm(model, shaft - 1e-8, motors, S3)
                # in balance, up to friction and to what a hundred-millionth of a radian makes
                assert abs(held_nm(model, shaft, motors, S3)) <= friction_nm + growth_nm + 1e-12
                assert min(motors) - 1 <= shaft <= max(motors) + 1e-9 + friction_nm / 0.03


def test_friction_holds_the_shaft_and_stops_it_early() -> None:
    motors = (0.4, -0.4)
    free = rest("qbmove-maker-pro", motors, FREE)
    stiffness = stiffness_nm_per_rad(0.4 / RAD_PER_TICK, "qbmove-maker-pro")
    for side in (-1, 1):
        near = free + side * 0.009 / stiffness
        assert rest("qbmove-maker-pro", motors, FREE, 0.01, near) == near
        stopped = rest("qbmove-maker-pro", motors, FREE, 0.01, free + side * 1.0)
        assert stopped - free == pytest.approx(side * 0.01 / stiffness, rel=1e-3)
        # and there it stays
        assert rest("qbmove-maker-pro", motors, FREE, 0.01, stopped) == stopped


def test_the_way_to_rest_is_first_order_for_any_step() -> None:
    joint = SpringJoint(SPRINGS["qbmove-maker-pro"], 0.0, 0.02)
    motors = (0.8, 0.4)
    end = joint.moved(0.0, math.inf, motors, FREE)
    at_once = joint.moved(0.0, 0.02, motors, FREE)
    assert at_once == pytest.approx(end * (1 - math.exp(-1)), rel=1e-9)
    shaft = 0.0
    for _ in range(20):
        shaft = joint.moved(shaft, 0.001, motors, FREE)
    assert shaft == pytest.approx(at_once, rel=1e-9)


def test_settling_at_once() -> None:
    slow, quick = (SpringJoint(SPRINGS["qbmove-maker-pro"], 0.0, settling_s) for settling_s in (0.01, 0.0))
    assert quick.moved(0.0, 1e-3, (0.8, 0.4), S3) == slow.moved(0.0, math.inf, (0.8, 0.4), S3)


def test_the_rigid_joint_ignores_the_load_and_motor_2() -> None:
    assert RigidJoint().moved(0.0, 0.001, (2.5, -1.0), S3) == 2.5


@pytest.mark.parametrize("model", MODELS)
def test_a_shaft_said_to_be_free_is_where_every_millisecond_takes_it(model: str) -> None:
    """Of ways of the motors that are long, or a few ticks as while they hunt for their reference."""
    rng, said = np.random.default_rng(2), {"held": 0, "moved": 0, "touching": 0}
    joint = SpringJoint(SPRINGS[model], 0.01, 0.01)
    for _ in range(300):
        preset = float(rng.uniform(0.05, 0.6))
        before = preset, -preset
        after = preset + float(rng.normal(0, 2e-3)), -preset + float(rng.normal(0, 2e-3))
        probe = Probe(WorldSettings(gap_mm=float(rng.choice([0.0, 1e6]))))
        start = joint.moved(float(rng.normal(0, 0.03)), math.inf, before, probe)
        free = joint.free(start, before, after, probe)
        shaft = start
        for k in range(1, 6):
            now = before[0] + k / 5 * (after[0] - before[0]), before[1] + k / 5 * (after[1] - before[1])
            shaft = joint.moved(shaft, 0.001, now, probe)
        assert free is None or free == shaft
        said["touching" if start > probe.touch_rad else "moved" if free is None else "held"] += 1
    assert min(said.values()) > 20, said


def test_a_rigid_shaft_is_free_until_it_touches() -> None:
    touch = S3.touch_rad
    assert RigidJoint().free(0.0, (0.0, 0.0), (touch, 0.0), S3) == touch
    assert RigidJoint().free(0.0, (0.0, 0.0), (touch + 1e-9, 0.0), S3) is None
    assert RigidJoint().free(touch + 1e-9, (touch + 1e-9, 0.0), (0.0, 0.0), S3) is None
