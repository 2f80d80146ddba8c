"""Every guard is asked in every turn of every emulated run, also one that somebody has added."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import pytest

from benchmarks.rig.fault_case import read_log
from emg2vsa.rig.executor.guards import GUARDS, Check, Moment
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.record.ended import Ended
from emg2vsa.rig.rig_settings import GuardSettings, RigSettings
from emg2vsa.worlds.bench.settings import EmulatedSettings
from emg2vsa.worlds.bench.virtual_run import run_virtual

STARTED = datetime(2026, 3, 1, 9, 30, tzinfo=UTC)


def deep(moment: Moment, limits: GuardSettings) -> str | None:
    return f"{moment.depth_mm:.3f} mm" if moment.phase == "approach" and 1.0 < moment.depth_mm < 2.0 else None


def run(plan: RunPlan, folder: Path, *, exact: bool = False, **guards: dict[str, Check]) -> Ended:
    return run_virtual(plan, RigSettings(), EmulatedSettings(exact=exact), folder, started=STARTED, **guards)


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("kind", ["high-stiffness", "modular", "plate"])
def test_a_guard_of_ones_own_ends_the_run_off_contact(
    plan: Callable[..., RunPlan], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, exact: bool
) -> None:
    monkeypatch.setitem(GUARDS, "mine", deep)
    condition = "high-stiffness" if kind == "plate" else kind
    ended = run(plan(condition, repetitions=1, plate=kind == "plate"), tmp_path / "run", exact=exact)
    first_mm = RigSettings().depth_at(
        next(row.position_deg or 0 for row in reversed(read_log(tmp_path / "run" / "log.csv")) if row.phase != "escape")
    )
    assert (ended.how, ended.cause, ended.retracted) == ("guard", "mine", True)
    # the turn in which it speaks sends nothing
    assert float(ended.why.removesuffix(" mm")) == pytest.approx(first_mm + 5.0 / 200, abs=0.01)
    assert 0.97 < first_mm <= 1.01


def test_guards_that_are_handed_over_are_the_ones_asked(plan: Callable[..., RunPlan], tmp_path: Path) -> None:
    handed_over = dict(GUARDS)
    rigid = plan("high-stiffness", repetitions=1)
    assert run(rigid, tmp_path / "mine", guards={**handed_over, "mine": deep}).cause == "mine"
    assert run(rigid, tmp_path / "all", guards=handed_over).how == "completed"


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("condition", ["high-stiffness", "modular"])
def test_every_guard_is_asked_twice_in_every_logged_turn(
    plan: Callable[..., RunPlan], tmp_path: Path, condition: str, exact: bool
) -> None:
    asked: dict[str, list[str]] = {name: [] for name in GUARDS}

    def noting(name: str) -> Check:
        def check(moment: Moment, limits: GuardSettings) -> str | None:
            asked[name].append(f"{moment.now_s:.6f}")
            return GUARDS[name](moment, limits)

        return check

    ended = run(
        plan(condition, repetitions=1), tmp_path / "run", exact=exact, guards={name: noting(name) for name in GUARDS}
    )
    turns = [f"{row.time_s:.6f}" for row in read_log(tmp_path / "run" / "log.csv") if row.phase != "escape"]
    assert (ended.how, len(set(turns))) == ("completed", len(turns))
    for name, times in asked.items():
        assert times == [turn for turn in turns for _ in range(2)], name
