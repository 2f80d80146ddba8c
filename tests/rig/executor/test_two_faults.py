"""Two faults that hide each other, and healthy rigs that only look faulty: on the emulated rig."""

from __future__ import annotations

import math
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.rig.plans import modular_plan, rigid_plan
from emg2vsa.devices.clock import VirtualClock
from emg2vsa.rig.executor.control_cycle import ControlCycle
from emg2vsa.rig.executor.execute import execute
from emg2vsa.rig.plan import RIGID, RunPlan
from emg2vsa.rig.record.ended import Ended
from emg2vsa.rig.rig_settings import GuardSettings, RigSettings
from emg2vsa.worlds.bench.bench import EmulatedRig
from emg2vsa.worlds.bench.faults import put
from emg2vsa.worlds.bench.settings import EmulatedSettings

STARTED = datetime(2026, 3, 1, 9, 30, tzinfo=UTC)


class Pressed:
    """A run, and the largest true force on the specimen."""

    def __init__(self, plan: RunPlan, emulated: EmulatedSettings | None = None) -> None:
        self.clock, self.plan = VirtualClock(), plan
        rigid = plan.condition == RIGID
        emulated = emulated or EmulatedSettings(world="elastic", seed=14)
        self.bench = EmulatedRig(emulated, plan.specimen, plan.angle_deg, rigid, self.clock, run=plan.condition)
        self.peak_n, self.rest_n = 0.0, 0.0

    def run(self, folder: Path, monkeypatch: pytest.MonkeyPatch, watch: Callable[[Any], None] = lambda motion: None,
            rig: RigSettings | None = None) -> Ended:  # fmt: skip
        turn = ControlCycle.turn

        def watched(cycle: ControlCycle, now_s: float, late_s: float) -> Any:
            watch(cycle.motion)
            self.peak_n = max(self.peak_n, self._true_n())
            return turn(cycle, now_s, late_s)

        monkeypatch.setattr(ControlCycle, "turn", watched)
        ended = execute(self.plan, rig or RigSettings(), self.bench.devices(), folder, self.clock, started=STARTED)
        self.rest_n = self._true_n()
        return ended

    def _true_n(self) -> float:
        return float(np.linalg.norm(self.bench.world.force_n(self.clock.now_s())))


@pytest.mark.parametrize("condition", ["modular", "constant-min", "constant-max"])
@pytest.mark.parametrize(("gain", "ticks"), [(0.25, 400), (0.6, 100), (0.5, -150)])
def test_a_wrong_zero_of_the_shaft_is_found_before_it_hides_a_wrong_gain(
    condition: Any, gain: float, ticks: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pressed = Pressed(modular_plan(1, specimen="S1", condition=condition))
    put(pressed.bench, f"gain {gain}")
    put(pressed.bench, f"jumped-shaft {ticks}")
    ended = pressed.run(tmp_path / "run", monkeypatch)
    assert (ended.how, ended.phase, ended.retracted) == ("guard", "home", True)
    assert ended.cause in ("springs at rest", "untrusted force")
    assert pressed.peak_n == 0


@pytest.mark.parametrize("ticks", [45, -60])
def test_a_zero_of_the_shaft_a_tenth_of_a_millimetre_off_is_told(
    ticks: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pressed = Pressed(modular_plan(1))
    put(pressed.bench, f"jumped-shaft {ticks}")
    ended = pressed.run(tmp_path / "run", monkeypatch)
    assert (ended.phase, ended.cause in ("springs at rest", "untrusted force")) == ("home", True)


def test_a_noisy_sensor_is_no_preload(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pressed = Pressed(
        modular_plan(3, specimen="S3", pause_s=0.5), EmulatedSettings(world="elastic", force_noise_n=0.2, seed=3)
    )
    ended = pressed.run(tmp_path / "run", monkeypatch)
    assert (ended.how, ended.cause, ended.repetitions_done) == ("completed", "", 3)


def test_a_probe_that_presses_in_the_pause_is_found_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pressed = Pressed(modular_plan(1, pause_s=1.0))
    pushes = iter([lambda: put(pressed.bench, "push 0.7")])

    def push(motion: Any) -> None:
        if motion.phase == "pause":
            next(pushes, lambda: None)()

    ended = pressed.run(tmp_path / "run", monkeypatch, push)
    assert (ended.how, ended.cause, ended.phase) == ("guard", "preload", "pause")


@pytest.mark.parametrize("condition", ["modular", "high-stiffness"])
@pytest.mark.parametrize(("angle_deg", "friction"), [(45.0, 0.6), (30.0, 0.4)])
def test_skin_that_holds_on_to_a_tilted_specimen_is_no_fault(
    condition: Any, angle_deg: float, friction: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make = rigid_plan if condition == RIGID else modular_plan
    pressed = Pressed(make(1, specimen="S1", angle_deg=angle_deg, pause_s=0.5))
    sticky(pressed.bench, angle_deg, friction)
    ended = pressed.run(tmp_path / "run", monkeypatch)
    assert (ended.how, ended.why) == ("completed", "")


def sticky(bench: EmulatedRig, angle_deg: float, friction: float, slip_mm: float = 0.3) -> None:
    """The sensor feels friction of the skin along the surface, full after it has slid by ``slip_mm``."""
    felt, tilt = bench.box.faults.felt, math.radians(angle_deg)
    last: list[float] = []
    held = [0.0]

    def with_friction(wrench: Any, time_s: float) -> Any:
        x_n, y_n, z_n, *torques = wrench
        depth_mm = bench.world.probe_mm(time_s)
        slid_mm = (depth_mm - last[-1]) * math.sin(tilt) if last else 0.0
        last[:] = [depth_mm]
        normal_n = math.hypot(x_n, z_n)
        held[0] = max(-slip_mm, min(slip_mm, held[0] + slid_mm)) if normal_n else 0.0
        along_n = friction * normal_n * held[0] / slip_mm
        return felt((x_n - along_n * math.cos(tilt), y_n, z_n + along_n * math.sin(tilt), *torques), time_s)

    bench.box.faults.felt = with_friction  # type: ignore[method-assign]


@pytest.mark.parametrize("condition", ["modular", "high-stiffness"])
def test_a_force_that_lags_leaves_no_probe_pressed(
    condition: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make = rigid_plan if condition == RIGID else modular_plan
    pressed = Pressed(make(1, specimen="S1"))
    lags = iter([lambda: put(pressed.bench, "lag 300")])

    def lag(motion: Any) -> None:
        if motion.phase == "load":
            next(lags, lambda: None)()

    ended = pressed.run(tmp_path / "run", monkeypatch, lag)
    assert (ended.how, ended.retracted, ended.deactivated) == ("guard", True, True)
    assert pressed.rest_n < 0.05
    assert "computer was busy" not in " ".join(ended.notes)


@pytest.mark.parametrize("following_s", [0.1, 0.2])
def test_more_patience_with_the_motors_ends_no_healthy_run(
    following_s: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig = RigSettings(guards=GuardSettings(following_s=following_s))
    ended = Pressed(modular_plan(1, pause_s=0.5)).run(tmp_path / "run", monkeypatch, rig=rig)
    assert (ended.how, ended.why) == ("completed", "")


@pytest.mark.parametrize(("condition", "gain"), [("constant-min", 0.74), ("modular", 1.0)])
def test_a_gain_that_no_guard_sees_makes_the_press_doubtful(
    condition: Any, gain: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pressed = Pressed(modular_plan(1, specimen="S1", condition=condition, stiffness_n_per_mm=None))
    if gain != 1.0:
        put(pressed.bench, f"gain {gain}")
    ended = pressed.run(tmp_path / "run", monkeypatch)
    assert ended.how == "completed"
    assert ("press 1 is doubtful: the force sensor feels" in " ".join(ended.notes)) == (gain != 1.0)
