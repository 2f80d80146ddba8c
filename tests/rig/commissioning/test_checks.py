"""The settings that protect a rig, found anew on an emulated bench whose rig file is wrong."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.protocols import Devices
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK
from emg2vsa.errors import DeviceError
from emg2vsa.rig.commissioning.checks import Check, check_rig
from emg2vsa.rig.commissioning.hand_motion import HandMotion
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.worlds.bench.bench import EmulatedRig
from emg2vsa.worlds.bench.settings import EmulatedSettings

TRUE = RigSettings(home_deg=-300 * DEG_PER_TICK)
SOFT = EmulatedSettings(gap_mm=4.0)


class Ruler:
    """A person with a calliper at the emulated bench; and how hard the probe has pressed at most."""

    def __init__(
        self, rig: RigSettings = TRUE, *, rigid: bool = False, emulated: EmulatedSettings = SOFT, pad: str = "S5"
    ) -> None:
        self.clock = VirtualClock()
        self.bench = EmulatedRig(emulated, pad, 0.0, rigid, self.clock, rig=rig)
        self.start_mm = self.probe_mm()
        self.touch_mm = math.nan
        self.most_n = 0.0
        wrenches = self.bench.box._wrenches

        def felt(times_s: Any) -> Any:
            found = wrenches(times_s)
            self.most_n = max(self.most_n, *(math.hypot(*each[:3]) for each in found))
            return found

        self.bench.box._wrenches = felt

    def probe_mm(self) -> float:
        self.bench.firmware.advance()
        return self.bench.world.probe_mm(self.clock.now_s())

    def towards(self, degrees: float) -> bool:
        return self.probe_mm() > self.start_mm

    def moved_mm(self, degrees: float) -> float:
        return round(self.touch_mm - self.probe_mm(), 1)

    def zero_calliper(self) -> None:
        self.touch_mm = self.probe_mm()

    def check(self, said: RigSettings, person: Any = None) -> dict[str, Check]:
        devices = self.bench.devices()
        hand = HandMotion(Devices(devices.actuator, devices.force), said, self.clock)
        found = check_rig(hand, said, person or self, lambda text: None)
        devices.actuator.deactivate()
        return {check.key: check for check in found}


WRONG: dict[str, dict[str, Any]] = {
    "none": {},
    "push_axis": {"push_axis": (1.0, 0.0, 0.0)},
    "push_axis, its sign": {"push_axis": (0.0, 0.0, -1.0)},
    "push_sign": {"push_sign": -1},
    "home_deg": {"home_deg": 3800 * DEG_PER_TICK},
    "gear_mm_per_degree": {"gear_mm_per_degree": 0.1},
}


@pytest.mark.parametrize(
    ("wrong", "rigid"),
    [
        *((wrong, False) for wrong in WRONG if wrong != "push_axis"),
        ("push_axis", True),
        pytest.param("push_axis", False, marks=pytest.mark.slow),
        *(pytest.param(wrong, True, marks=pytest.mark.slow) for wrong in WRONG if wrong != "push_axis"),
    ],
)
def test_each_wrong_setting_is_found_and_no_other(wrong: str, rigid: bool) -> None:
    ruler = Ruler(rigid=rigid)
    found = ruler.check(replace(TRUE, **WRONG[wrong]))
    assert [key for key, check in found.items() if not check.good] == [key.partition(",")[0] for key in WRONG[wrong]]
    assert ruler.most_n < 0.8


def test_all_four_at_once_are_mended_to_those_of_the_bench() -> None:
    ruler = Ruler()
    wrong = replace(TRUE, push_axis=(0.0, 1.0, 0.0), push_sign=-1, home_deg=3800 * DEG_PER_TICK, gear_mm_per_degree=0.1)
    found = ruler.check(wrong)
    assert found["push_axis"].found == (0.0, 0.0, 1.0)
    assert found["push_sign"].found == 1
    assert found["gear_mm_per_degree"].found == pytest.approx(0.2, rel=0.01)
    assert TRUE.depth_at(found["home_deg"].found) == pytest.approx(ruler.touch_mm - 3.0, abs=0.15)
    assert ruler.most_n < 0.8
    mended = replace(wrong, **{key: check.found for key, check in found.items() if check.found is not None})
    assert all(check.good for check in Ruler().check(mended).values())


def test_an_oblique_axis_is_found() -> None:
    axis = (0.6, 0.0, 0.8)
    found = Ruler(replace(TRUE, push_axis=axis)).check(TRUE)
    assert np.degrees(np.arccos(np.dot(found["push_axis"].found, axis))) < 2


class Nobody:
    """Scripts cannot look."""

    def towards(self, degrees: float) -> None:
        return None

    def zero_calliper(self) -> None:
        pass

    def moved_mm(self, degrees: float) -> None:
        return None


def test_without_a_person_the_sign_is_searched_and_the_gear_left() -> None:
    found = Ruler().check(replace(TRUE, push_sign=-1), Nobody())
    assert (found["push_sign"].found, found["gear_mm_per_degree"].found) == (1, None)


def test_no_touch_is_told() -> None:
    far = Ruler(emulated=replace(SOFT, gap_mm=60.0))
    with pytest.raises(
        DeviceError,
        match=r"probe: expected a touch within 45 degrees, but found none\. Put the pad "
        r"nearer",
    ):
        far.check(TRUE)


def test_a_sensor_that_feels_nothing_does_not_let_the_probe_press_on() -> None:
    ruler = Ruler(pad="S1")
    truly = ruler.bench.box._wrenches
    ruler.bench.box._wrenches = lambda times_s: [tuple(0.0 * part for part in each) for each in truly(times_s)]
    with pytest.raises(
        DeviceError, match="expected a force felt where the springs give way, but found springs that press"
    ):
        ruler.check(TRUE)
    assert ruler.most_n < 10
