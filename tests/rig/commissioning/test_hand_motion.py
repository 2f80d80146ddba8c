"""Moves by hand with a force sensor or a shaft that lies: how hard the probe truly presses, and how it is left."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.protocols import Devices
from emg2vsa.errors import DeviceError
from emg2vsa.rig.commissioning.hand_motion import LIMIT_SHARE, HandMotion
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.worlds.bench.bench import EmulatedRig
from emg2vsa.worlds.bench.faults import put
from emg2vsa.worlds.bench.settings import EmulatedSettings

RIG = RigSettings()
MOST_N = LIMIT_SHARE * RIG.guards.force_n


class Bench:
    """A probe 2 mm above the stiffest specimen; ``peak_n``: the largest force there truly was."""

    def __init__(self, *, rigid: bool) -> None:
        self.clock, self.peak_n = VirtualClock(), 0.0
        self.rig = EmulatedRig(EmulatedSettings(gap_mm=2.0), "S1", 0.0, rigid, self.clock, rig=RIG)
        devices = self.rig.devices()
        self.actuator, self.force = devices.actuator, devices.force
        self.hand = HandMotion(Devices(devices.actuator, devices.force), RIG, self.clock)
        truly = self.rig.world._run

        def run(until_s: float, moving: Any) -> None:
            truly(until_s, moving)
            self.peak_n = max(self.peak_n, self.true_n(self.rig.world._path.end_s))

        self.rig.world._run = run  # type: ignore[method-assign]

    def true_n(self, time_s: float) -> float:
        world = self.rig.world
        touch = world._path.touch(time_s) if world._probe.remembers else world._probe.elastic_touch(world._path.end_rad)
        return float(np.linalg.norm(world._probe.force_n(touch)))

    def press(self, faults: tuple[str, ...], *, until_n: float, deg_per_s: float) -> str:
        """Towards the specimen; the error, or nothing."""
        self.hand.start()
        for fault in faults:
            put(self.rig, fault)
        begin = self.hand.at_deg
        try:
            if self.hand.go(begin + 60, until_n=until_n, deg_per_s=deg_per_s).touched:
                self.hand.away(begin)
        except DeviceError as error:
            return str(error)
        return ""

    def felt_n(self, after_s: float) -> float:
        self.clock.sleep_until(self.clock.now_s() + after_s)
        return float(np.linalg.norm(self.force.read().force_n))

    def left_n(self) -> float:
        """Motors off, a second later."""
        self.actuator.deactivate()
        for _ in range(200):
            self.felt_n(0.005)
        self.rig.firmware.advance()
        return float(np.linalg.norm(self.rig.world.force_n(self.clock.now_s())))


LYING = [
    ("gain 0.1",), ("gain 0.5",), ("dead on",), ("dead on", "jumped-shaft 500"), ("lag 200",), ("frozen-motor-1 on",),
]  # fmt: skip
BETWEEN = [("gain 0.3",), ("dead on", "jumped-shaft -500")]
"""What is told by the same guards as faults of LYING."""


@pytest.mark.parametrize(
    ("faults", "rigid"),
    [
        *((faults, False) for faults in LYING),
        *((faults, True) for faults in LYING[:3]),
        *(pytest.param(faults, True, marks=pytest.mark.slow) for faults in LYING[3:]),
        *(pytest.param(faults, rigid, marks=pytest.mark.slow) for faults in BETWEEN for rigid in (False, True)),
    ],
)
def test_no_lying_sensor_lets_the_probe_press_too_hard(faults: tuple[str, ...], rigid: bool) -> None:
    for until_n, deg_per_s in ((2.0, 5.0), (MOST_N, 25.0)):
        bench = Bench(rigid=rigid)
        bench.press(faults, until_n=until_n, deg_per_s=deg_per_s)
        assert bench.peak_n <= 1.3 * RIG.guards.force_n


@pytest.mark.parametrize("rigid", [False, True])
def test_a_sound_rig_reaches_the_largest_limit_and_is_left_free(rigid: bool) -> None:
    bench = Bench(rigid=rigid)
    assert bench.press((), until_n=MOST_N, deg_per_s=25.0) == ""
    assert MOST_N <= bench.peak_n < 1.4 * MOST_N
    assert bench.left_n() < 0.5


@pytest.mark.parametrize(("rigid", "wanted"), [(False, "springs give way"), (True, "motors that draw at most 0.45 A")])
def test_after_an_error_the_probe_has_gone_back(rigid: bool, wanted: str) -> None:
    bench = Bench(rigid=rigid)
    assert wanted in bench.press(("dead on",), until_n=2.0, deg_per_s=5.0)
    assert bench.peak_n > 3
    assert bench.left_n() < 0.5


@pytest.mark.parametrize("rigid", [False, True])
def test_home_takes_away_a_probe_that_stands_pressed_beyond_the_limit(rigid: bool) -> None:
    bench = Bench(rigid=rigid)
    actuator = bench.actuator
    actuator.activate()
    actuator.command(RIG.position_at(6.5 if rigid else 13), 0.0 if rigid else RIG.stiffness_percent[0] / 100)
    for _ in range(300):  # the watchdog is fed, and the force asked for
        assert actuator.is_active()
        bench.felt_n(0.005)
    assert bench.left_n() > RIG.guards.force_n
    bench.hand.start()
    assert not bench.hand.go(RIG.home_deg, until_n=0.5, from_zero=False).touched
    assert bench.left_n() < 0.5
