"""A rig of fakes on the virtual clock: a probe over a linear spring, and every fault on demand at a given time."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.protocols import (
    Devices,
    ForceCounts,
    ForceSample,
    Frame,
    LogColumns,
    Measurements,
    Rating,
    SensorStatus,
)
from emg2vsa.devices.qbmove.springs import SpringJoint
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK, LOG_COLUMNS, to_ticks
from emg2vsa.errors import DeviceError
from emg2vsa.profiles import Profile, Profiles
from emg2vsa.rig.executor.execute import execute
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.record.ended import Ended
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.schedules import Schedule
from emg2vsa.schedules.build import build_schedules
from emg2vsa.settings import ScheduleSettings

RIG = RigSettings(filter_samples=1)
STARTED = datetime(2026, 3, 1, 9, 30, tzinfo=UTC)
SURFACE_MM, STIFFNESS_N_PER_MM = 1.0, 5.0
START_TICKS = 200
JOINT = SpringJoint("qbmove-maker-pro", RIG.full_preset)
FRAME_S = 0.05


def make_schedule(condition: str = "modular") -> Schedule:
    force = np.linspace(0.5, 7, 100)
    v = 42e-6 + 20e-6 * np.log(force)
    profile = Profile("S1", 7.63, 42e-6, 20e-6, force, v, "measured", 10, np.full(100, np.nan))
    profiles = Profiles(
        profiles=(profile,), new=None, weight_alpha=math.nan, bracket=None, new_measured=None, new_error=None,
        leave_one_out=(), participant="", unit="V", notes=(),
    )  # fmt: skip
    chosen: Any = (condition,)
    (schedule,) = build_schedules(profiles, ScheduleSettings(conditions=chosen), {"study": "palpation"})
    return schedule


def make_plan(**changes: Any) -> RunPlan:
    values: dict[str, Any] = {
        "specimen": "S1", "angle_deg": 30.0, "condition": "modular", "repetitions": 2, "f_max_n": 7.0, "pause_s": 0.2,
    } | changes  # fmt: skip
    rigid = values["condition"] == "high-stiffness"
    values.setdefault("schedule", None if rigid else make_schedule(values["condition"]))
    return RunPlan(**values)


class HeldUpClock(VirtualClock):
    """Sleeps 0.2 s too long, once, at ``hold_up_s``."""

    hold_up_s = math.inf

    def sleep_until(self, time_s: float) -> None:
        if time_s >= self.hold_up_s:
            self.hold_up_s, time_s = math.inf, time_s + 0.2
        super().sleep_until(time_s)


@dataclass
class Bench:
    """Actuator, force sensor and camera in one. ``fault`` begins at ``fault_s``."""

    clock: HeldUpClock = field(default_factory=HeldUpClock)
    fault: str = ""
    fault_s: float = math.inf
    sent: list[tuple[int, int]] = field(default_factory=list)
    "Position and preset of every attempt, ticks as a qbmove is sent them, also of those that failed."
    calls: list[str] = field(default_factory=list)
    forces_n: list[float] = field(default_factory=list)
    "Every force handed out."
    shape: tuple[int, int] = (12, 16)
    delay_s: float = 0.0
    rating: Rating | None = None
    joint: SpringJoint | None = JOINT
    columns: LogColumns = LOG_COLUMNS
    force_counts: ForceCounts = field(default_factory=ForceCounts)
    _position: int = START_TICKS
    _frames: int = 0
    _fresh_s: float = 0.0

    def on(self, fault: str) -> bool:
        return self.fault == fault and self.clock.now_s() >= self.fault_s

    def once(self, fault: str) -> bool:
        now = self.on(fault)
        if now:
            self.fault = ""
        return now

    def activate(self) -> None:
        self.calls.append("activate")
        if self.on("refusal"):
            raise lost("qbmove 1, refusal")

    def deactivate(self) -> None:
        self.calls.append("deactivate")
        if self.on("dead actuator"):
            raise lost("qbmove 1")

    def is_active(self) -> bool:
        return not self.on("motors off")

    def command(self, position_deg: float, preset: float) -> None:
        self.calls.append("set")
        preset_ticks = preset * JOINT.full_ticks
        assert preset_ticks == pytest.approx(round(preset_ticks), abs=1e-6)
        self.sent.append((to_ticks(position_deg), round(preset_ticks)))
        if self.on("dead actuator") or self.once("one lost reply"):
            raise lost("qbmove 1")
        self._position = self.sent[-1][0]

    def position_deg(self) -> float:
        if self.on("dead actuator"):
            raise lost("qbmove 1")
        return self._position * DEG_PER_TICK

    def measurements(self) -> Measurements:
        if self.once("Ctrl-C"):
            raise KeyboardInterrupt
        if self.joint is None:
            return measured(self._position, 0, self._position)
        preset = self.sent[-1][1] if self.sent else 0
        motors = self._position + preset, self._position - preset
        # the probe goes where the motors go; of the springs it has only the way in which the encoders tell the force
        low, high = self._position - 3000, self._position + 3000
        while high - low > 1:
            middle = (low + high) // 2
            spring_n = -self.joint.torque_nm(measured(*motors, middle)) / RIG.lever_m
            low, high = (low, middle) if spring_n < self._force_n() else (middle, high)
        return measured(*motors, low)

    def currents_a(self) -> tuple[float, float]:
        if self.once("bug"):
            raise ZeroDivisionError("division by zero")
        return 0.1, -0.09

    def current_limit_a(self) -> float:
        return 1.5

    def read(self) -> ForceSample:
        if self.on("dead sensor"):
            raise lost("force sensor")
        if not self.on("stale"):
            self._fresh_s = self.clock.now_s()
        force_n, faults = self._force_n(), ()
        if self.on("too much"):
            force_n = RIG.guards.force_n + 0.1
        if self.on("jump"):
            force_n += 2.0
        if self.on("not a number"):
            force_n = math.nan
        if self.on("saturated"):
            faults = ("gauge saturated",)
        self.forces_n.append(force_n)
        return ForceSample(self._fresh_s, (0.0, 0.0, force_n), (0.0, 0.0, 0.0), SensorStatus(faults=faults))

    def read_all(self) -> list[ForceSample]:
        return []

    def counts(self) -> ForceCounts:
        return self.force_counts

    def frames(self) -> list[Frame]:
        if self.on("dead camera"):
            raise lost("camera")
        taken = []
        while not self.on("no frames") and (self._frames + 1) * FRAME_S <= self.clock.now_s():
            self._frames += 1
            taken.append(Frame(self._frames * FRAME_S, np.full(self.shape, self._frames % 256, np.uint8)))
        return taken

    def stop(self) -> str | None:
        return "SIGTERM" if self.on("SIGTERM") else None

    def devices(self, camera: bool = True) -> Devices:
        return Devices(self, self, self if camera else None)

    def run(self, folder: Path, plan: RunPlan | None = None, rig: RigSettings = RIG, camera: bool = True) -> Ended:
        if self.fault == "held up":
            self.clock.hold_up_s = self.fault_s
        plan = plan or make_plan()
        self.joint = None if plan.condition == "high-stiffness" else JOINT
        return execute(plan, rig, self.devices(camera), folder, self.clock, started=STARTED, stop=self.stop)

    def _force_n(self) -> float:
        softening = math.exp(-(self.clock.now_s() - self.fault_s) / 0.05) if self.on("specimen gone") else 1.0
        return softening * STIFFNESS_N_PER_MM * max(0.0, RIG.depth_at(self._position * DEG_PER_TICK) - SURFACE_MM)


def measured(*ticks: int) -> Measurements:
    motor_1, motor_2, shaft = (each * DEG_PER_TICK for each in ticks)
    return Measurements((motor_1, motor_2), shaft)


def lost(where: str) -> DeviceError:
    return DeviceError(where, wanted="an answer", found="none", do="Check the cable.")


@pytest.fixture
def bench() -> Bench:
    return Bench()


@pytest.fixture
def new_bench() -> Callable[..., Bench]:
    return Bench


@pytest.fixture
def plan_of() -> Callable[..., RunPlan]:
    return make_plan


@pytest.fixture
def rig() -> RigSettings:
    """With the force as it is, unfiltered."""
    return RIG
