"""Where a run begins and ends when the retracted probe is not at 0 ticks, or was left down: every actuator."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import pytest

from benchmarks.rig.fault_case import read_log
from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.protocols import Devices
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK
from emg2vsa.rig.executor.execute import execute
from emg2vsa.rig.plan import RIGID, RunPlan
from emg2vsa.rig.record.ended import Ended
from emg2vsa.rig.record.run_log import Row
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.worlds.bench.bench import EmulatedRig
from emg2vsa.worlds.bench.faults import put
from emg2vsa.worlds.bench.settings import EmulatedSettings

ENCODER_MM = 8 * DEG_PER_TICK * 0.2
"""A step of the 12 bits, at the probe."""
ACTUATORS = {
    "rigid": (RIGID, "qbmove-maker-pro"),
    "maker-pro": ("modular", "qbmove-maker-pro"),
    "advanced": ("constant-mean", "qbmove-advanced"),
}
pytestmark = pytest.mark.parametrize(
    ("home_ticks", "condition", "springs"),
    [
        pytest.param(
            ticks, *actuator, id=f"{ticks}-{name}", marks=pytest.mark.slow if ticks == 0 and name != "rigid" else ()
        )
        for ticks in (-6000, 0)
        for name, actuator in ACTUATORS.items()
    ],
)


@dataclass
class Case:
    """A bench, retracted, and a run of one press on it."""

    bench: EmulatedRig
    devices: Devices
    plan: RunPlan
    folder: Path

    def leave_probe_at(self, depth_mm: float) -> None:
        actuator, clock = self.devices.actuator, self.bench.clock
        actuator.activate()
        for _ in range(10):
            actuator.command(self.bench.rig.position_at(depth_mm), 0.0 if self.bench.rigid else 0.2)
            clock.sleep_until(clock.now_s() + 0.1)
        actuator.deactivate()

    def run(self, stop: Callable[[], str | None] = lambda: None) -> tuple[Ended, list[Row]]:
        started = datetime(2026, 3, 1, tzinfo=UTC)
        ended = execute(
            self.plan, self.bench.rig, self.devices, self.folder, self.bench.clock, started=started, stop=stop
        )
        return ended, read_log(self.folder / "log.csv")

    def probe_mm(self) -> float:
        """The true depth."""
        return self.bench.world.probe_mm(self.bench.clock.now_s())

    def turn_mm(self) -> float:
        """What the ramp moves in a turn of the loop, and half a tick."""
        return self.plan.ramp_mm_per_s * self.bench.rig.period_s + ENCODER_MM / 16


@pytest.fixture
def case(plan: Callable[..., RunPlan], tmp_path: Path, condition: str, springs: str, home_ticks: int) -> Case:
    rig = RigSettings(home_deg=home_ticks * DEG_PER_TICK)
    emulated = EmulatedSettings(springs=springs)  # type: ignore[arg-type]
    bench = EmulatedRig(emulated, "S3", 0.0, condition == RIGID, VirtualClock(), rig=rig)
    return Case(bench, bench.devices(), plan(condition, repetitions=1), tmp_path / "run")


def test_a_run_from_home_begins_without_a_jump_and_ends_retracted(case: Case, home_ticks: int) -> None:
    ended, rows = case.run()
    assert abs(case.bench.rig.depth_at(rows[0].position_deg or 0)) <= case.turn_mm()
    assert (ended.how, ended.retracted, ended.deactivated, ended.notes) == ("completed", True, True, ())
    depths_mm = [case.bench.rig.depth_at(row.position_deg or 0) for row in rows]
    assert min(depths_mm) == 0
    assert rows[-1].position_deg == home_ticks * DEG_PER_TICK
    assert case.bench.rig.depth_at(case.devices.actuator.position_deg()) == pytest.approx(0, abs=2 * ENCODER_MM)
    # friction holds a shaft on springs a little off its motors
    assert case.probe_mm() == pytest.approx(0, abs=2 * ENCODER_MM if case.bench.rigid else 1.0)
    # the depth logged is the true one
    assert sum(row.at is not None for row in rows) > 100
    for row in rows:
        if row.at is not None:
            true_mm = case.bench.world.probe_mm(row.time_s)
            assert case.bench.rig.depth_at(row.at.shaft_deg) == pytest.approx(true_mm, abs=2 * ENCODER_MM)


def test_a_probe_left_down_goes_home_from_where_it_stands(case: Case) -> None:
    case.leave_probe_at(2.0)
    stands_mm = case.bench.rig.depth_at(case.devices.actuator.position_deg())
    assert stands_mm == pytest.approx(2.0, abs=2 * ENCODER_MM)
    ended, rows = case.run()
    assert (ended.how, ended.retracted) == ("completed", True)
    assert rows[0].phase == "home"
    first_mm = case.bench.rig.depth_at(rows[0].position_deg or 0)
    assert stands_mm - case.turn_mm() <= first_mm <= stands_mm


def test_motors_that_have_gone_off_are_led_away(case: Case) -> None:
    def cut_off() -> None:
        if case.probe_mm() > 1.5:
            put(case.bench, "reset")

    ended, _ = case.run(stop=cut_off)
    assert (ended.cause, ended.retracted, ended.deactivated) == ("lost device", True, True)
    assert any("switched on where they stood" in note for note in ended.notes)
    assert case.probe_mm() < 1.0  # friction may hold a shaft on springs so far off motors at home


def test_motors_that_have_gone_off_and_hear_nothing_are_not_called_retracted(case: Case) -> None:
    def cut_off() -> None:
        if case.probe_mm() > 1.5:
            put(case.bench, "reset")
            put(case.bench, "deaf")

    ended, _ = case.run(stop=cut_off)
    assert (ended.cause, ended.retracted, ended.deactivated) == ("lost device", False, False)
    assert case.probe_mm() > 1.0
