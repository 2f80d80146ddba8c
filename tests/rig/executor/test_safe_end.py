"""The way out, where going away does not help, and where nobody lets it go."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.protocols import ForceSample
from emg2vsa.errors import DeviceError
from emg2vsa.rig.executor.safe_end import SafeEnd, Start, make_safe
from emg2vsa.rig.rig_settings import RigSettings

RIG = RigSettings()


@dataclass
class Probe:
    """Motors that are where they are sent; the force is a line over depth, none above ``surface_mm``."""

    surface_mm: float
    n_per_mm: float = 5.0
    offset_n: float = 0.0
    clock: VirtualClock = field(default_factory=VirtualClock)
    depths_mm: list[float] = field(default_factory=list)
    presets: list[float] = field(default_factory=list)
    obeys_from_s: float = 0.0
    interrupts: int = 0
    on: bool = True
    depth_mm: float = 4.0
    joint: None = None
    off_at_s: tuple[float, ...] = ()
    "When the motors go off by themselves."
    answers_from_s: float = 0.0
    wakes: bool = True
    asked_on: int = 0

    def is_active(self) -> bool:
        if self.clock.now_s() < self.answers_from_s:
            raise DeviceError("probe", wanted="an answer", found="none", do="Wait.")
        while self.off_at_s and self.clock.now_s() >= self.off_at_s[0]:
            self.on, self.off_at_s = False, self.off_at_s[1:]
        return self.on

    def activate(self) -> None:
        self.asked_on += 1
        if not self.wakes:
            raise DeviceError("probe", wanted="motors on", found="a refusal", do="See its supply.")
        self.on = True

    def command(self, position_deg: float, preset: float) -> None:
        self.depths_mm.append(RIG.depth_at(position_deg))
        self.presets.append(preset)
        if self.clock.now_s() >= self.obeys_from_s and (not self.off_at_s or self.is_active()) and self.on:
            self.depth_mm = self.depths_mm[-1]
        if self.interrupts:
            self.interrupts -= 1
            raise KeyboardInterrupt

    def position_deg(self) -> float:
        return RIG.position_at(self.depth_mm)

    def deactivate(self) -> None:
        self.on = False

    def force_n(self) -> float:
        return self.offset_n + abs(self.n_per_mm) * max(0.0, np.sign(self.n_per_mm) * (self.depth_mm - self.surface_mm))

    def log(self, position_deg: float, preset: float, notes: list[str]) -> ForceSample:
        return ForceSample(self.clock.now_s(), (0.0, 0.0, self.force_n()), (0.0, 0.0, 0.0))

    def leave(self, depth_mm: float = 4.0, home_is_free: bool = True) -> SafeEnd:
        self.depth_mm = depth_mm
        actuator: Any = self
        return make_safe(actuator, RIG, self.clock, Start(depth_mm, 0.8, 0.2, 0.5, home_is_free), self.log)


def test_it_goes_home_step_by_step_and_tells_the_last_force() -> None:
    probe = Probe(surface_mm=3.0)
    safe = probe.leave()
    assert (safe.retracted, safe.deactivated, safe.last_force_n, safe.notes) == (True, True, 0.0, ())
    assert min(np.diff(probe.depths_mm)) >= -0.11
    assert max(np.diff(probe.depths_mm)) <= 0


def test_twenty_times_ctrl_c_do_not_stop_it() -> None:
    probe = Probe(surface_mm=3.0, interrupts=20)
    safe = probe.leave()
    assert (safe.retracted, safe.deactivated) == (True, True)
    assert min(np.diff(probe.depths_mm)) >= -0.11


def test_a_force_that_grows_on_the_way_out_ends_it_soft_and_with_motors_off() -> None:
    probe = Probe(surface_mm=4.0, n_per_mm=-5.0)  # what is behind the probe is in its way
    safe = probe.leave()
    assert not safe.retracted
    assert not probe.on
    assert safe.last_force_n is not None
    assert safe.last_force_n <= 3.5  # 1 N twice, and a step of 0.1 mm each time
    assert probe.presets[-1] == 0.2
    assert any("the force grew" in note for note in safe.notes)


@pytest.mark.parametrize("home_mm", [0.0, -6.0])
def test_a_home_that_is_not_free_is_left_as_long_as_the_force_falls(home_mm: float) -> None:
    probe = Probe(surface_mm=home_mm - 2.0)
    safe = probe.leave(home_mm, home_is_free=False)
    assert probe.force_n() < 0.1
    assert probe.depth_mm > home_mm - 3.0
    assert (safe.retracted, safe.deactivated) == (False, True)  # free, but not at home


def test_a_sensor_with_another_zero_is_no_reason_to_go_far() -> None:
    probe = Probe(surface_mm=3.0, offset_n=2.0)
    safe = probe.leave(0.0, home_is_free=False)
    assert probe.depth_mm >= -1.0
    assert (safe.retracted, safe.last_force_n) == (False, 2.0)


def test_motors_that_obey_late_are_waited_for_while_the_probe_presses() -> None:
    probe = Probe(surface_mm=3.0, obeys_from_s=2.0)
    assert probe.leave().retracted
    assert probe.clock.now_s() < 3.0


def test_motors_that_never_obey_go_off_in_time() -> None:
    probe = Probe(surface_mm=3.0, obeys_from_s=1e9)
    safe = probe.leave()
    assert (safe.retracted, safe.deactivated, safe.last_force_n) == (False, True, 5.0)
    assert probe.clock.now_s() < 3.5


def test_motors_that_went_off_by_themselves_are_switched_on_once_and_lead_away() -> None:
    probe = Probe(surface_mm=3.0, on=False)
    safe = probe.leave()
    assert (safe.retracted, safe.deactivated, probe.asked_on, probe.on) == (True, True, 1, False)
    assert any("switched on where they stood" in note for note in safe.notes)
    assert min(np.diff(probe.depths_mm)) >= -0.11  # from where they stand, step by step


@pytest.mark.parametrize("heals_s", [0.4, 2.0])
def test_a_line_that_heals_on_the_way_out_leads_away(heals_s: float) -> None:
    probe = Probe(surface_mm=3.0, on=False, answers_from_s=heals_s)
    safe = probe.leave()
    assert (safe.retracted, safe.deactivated, probe.asked_on) == (True, True, 1)
    assert probe.clock.now_s() < heals_s + 2.0


def test_motors_that_go_off_again_are_left_where_they_are() -> None:
    probe = Probe(surface_mm=3.0, on=False, off_at_s=(0.05, 0.1))
    safe = probe.leave()
    assert (safe.retracted, safe.deactivated, probe.asked_on) == (False, True, 1)
    assert probe.clock.now_s() < 4.0


def test_motors_that_refuse_are_asked_once() -> None:
    probe = Probe(surface_mm=3.0, on=False, wakes=False)
    safe = probe.leave()
    assert (safe.retracted, probe.asked_on, probe.depth_mm) == (False, 1, 4.0)
    assert any("a refusal" in note for note in safe.notes)
