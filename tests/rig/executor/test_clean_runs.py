"""No guard speaks in a run without a fault, and no such run passes the largest force to expect. A small sample of
``python -m benchmarks.clean_runs``."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.rig.clean_run import clean_run


@pytest.mark.parametrize(
    ("specimen", "condition", "angle_deg", "step_n"),
    [
        ("S1", "modular", 0.0, 0.0),
        ("S1", "constant-max", 45.0, 0.0625),
        ("S5", "constant-min", 45.0, 0.0625),
        ("S5", "constant-min", 0.0, 0.0625),
        ("S3", "high-stiffness", 30.0, 0.0625),
        ("S1", "high-stiffness", 0.0, 0.0),
    ],
)
def test_a_clean_run_completes(specimen: str, condition: str, angle_deg: float, step_n: float, tmp_path: Path) -> None:
    outcome = clean_run(specimen, condition, angle_deg, step_n, 0, tmp_path / "run")
    assert (outcome.ended.how, outcome.ended.why) == ("completed", "")
    assert outcome.ended.retracted
    assert 0.9 * outcome.expected_n <= outcome.largest_n <= outcome.expected_n
