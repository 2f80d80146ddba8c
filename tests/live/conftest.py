"""Runs as the executor leaves them on disk, row by row."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest

import emg2vsa.live
from emg2vsa.devices.protocols import Measurements
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK, LOG_COLUMNS
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.record.ended import Ended
from emg2vsa.rig.record.run_log import Row
from emg2vsa.rig.record.run_record import RunRecord
from emg2vsa.rig.rig_settings import RigSettings

PLAN = RunPlan("S1", 30.0, "high-stiffness", repetitions=3, schedule=None, f_max_n=7.0)
RIG = RigSettings(home_deg=100 * DEG_PER_TICK)
SHAPE = (12, 16)
STARTED = datetime(2026, 3, 1, 9, 30, tzinfo=UTC)


def make_row(time_s: float = 0.0, **changes: Any) -> Row:
    wrench = 0.3, 0.4, 1.5, 0.01, 0.02, 0.03
    position_deg, preset, motor_1, motor_2, shaft = (ticks * DEG_PER_TICK for ticks in (1100, 600, 1400, 200, 1000))
    at = Measurements((motor_1, motor_2), shaft)
    row = Row(time_s, 1, "load", time_s, 1.5, 1.25, position_deg, preset, at, (0.01, -0.01), -1, 1e-4, *wrench, 0, 7000)
    return row._replace(**changes)


@pytest.fixture
def row() -> Callable[..., Row]:
    return make_row


@pytest.fixture
def runs(tmp_path: Path) -> Path:
    """Where runs will be; nothing is there yet."""
    return tmp_path / "runs"


@pytest.fixture
def begin(runs: Path) -> Callable[[str], RunRecord]:
    """A run that has just begun."""

    def begun(name: str) -> RunRecord:
        record = RunRecord(runs / name, STARTED, SHAPE, LOG_COLUMNS)
        record.plan(PLAN, RIG)
        return record

    return begun


@pytest.fixture
def ended() -> Callable[..., Ended]:
    """How a run ended: completed and safe, but for what is named."""
    whole = Ended("completed", "", "", "done", 3, 9.0, "", retracted=True, deactivated=True)
    return lambda **changes: replace(whole, **changes)


@pytest.fixture
def computed_by() -> Callable[[str], Callable[..., Any]]:
    """Results of functions in a page's state.js, called with plain values; ``each`` : with every row of many."""
    program = shutil.which("deno", path=str(Path(sys.executable).parent)) or shutil.which("deno")
    if program is None:
        pytest.skip("deno is not installed (extra 'test')")

    def of_page(page: str) -> Callable[..., Any]:
        path = Path(emg2vsa.live.__file__).parent / "page" / page / "state.js"

        def each(function: str, rows: Sequence[Sequence[Any]]) -> list[Any]:
            script = (
                f"import * as state from {json.dumps(path.as_uri())};"
                f"const rows = {json.dumps(rows)};"
                f"console.log(JSON.stringify(rows.map((row) => state.{function}(...row))));"
            )
            done = subprocess.run(
                [program, "run", "--quiet", "--no-config", "--ext=js", "-"],
                input=script, capture_output=True, text=True, timeout=300, check=True,
            )  # fmt: skip
            results: list[Any] = json.loads(done.stdout)
            return results

        def call(function: str, *arguments: Any) -> Any:
            return each(function, [arguments])[0]

        call.each = each  # type: ignore[attr-defined]
        return call

    return of_page
