"""The matrix would see lost data: taken away from a whole run, it is counted."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.rig.fault_bench import FaultBench
from benchmarks.rig.fault_case import lost_data
from benchmarks.rig.plans import modular_plan


@pytest.fixture
def whole(tmp_path: Path) -> tuple[Path, float]:
    """A run without a fault, and a time within its loading."""
    bench = FaultBench()
    ended = bench.run(modular_plan(1, specimen="S1", f_max_n=2.0, pause_s=0.0), tmp_path)
    assert ended
    assert ended.how == "completed"
    lines = (tmp_path / "log.csv").read_text().splitlines()
    return tmp_path, float(next(line for line in lines if ",retract," in line).split(",")[0])


def test_a_whole_run_lacks_nothing(whole: tuple[Path, float]) -> None:
    assert lost_data(*whole) == (0, 0, 0)


def test_a_row_taken_from_the_log_is_counted(whole: tuple[Path, float]) -> None:
    _without_line(whole[0] / "log.csv", 30)
    assert lost_data(*whole) == (1, 0, 0)


def test_a_row_taken_from_the_forces_is_counted(whole: tuple[Path, float]) -> None:
    _without_line(whole[0] / "press-001" / "force.csv", 30)
    assert lost_data(*whole) == (0, 1, 0)


def test_a_row_cut_short_is_counted(whole: tuple[Path, float]) -> None:
    log = whole[0] / "log.csv"
    log.write_bytes(log.read_bytes()[:-3])
    assert lost_data(*whole) == (1, 0, 0)


def _without_line(path: Path, number: int) -> None:
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:number] + lines[number + 1 :]))
