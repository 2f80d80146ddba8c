"""Faults that put 16 to 48 N on a specimen whose limit is 10 N before the guards were there; and no guard speaks in a
run without a fault, nor does such a run pass the largest force to expect: a small sample of benchmarks/rig."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.clean_runs import clean_run
from benchmarks.rig.fault_case import MOST_N, run_case, run_wrong

CASES = [
    ("commands ignored 2.1 s", False, "following", 13.0),
    ("force a fifth", False, "specimen", 13.0),
    ("force axis dead", False, "untrusted force", 13.0),
    ("both motors read 4096 less", False, "following", 13.0),
    ("both motors read 4096 less", True, "following", 13.0),
    ("force a fifth", True, "specimen", 13.0),
]


@pytest.mark.parametrize(("fault", "rigid", "cause", "most_n"), CASES)
def test_a_fault_while_loading(fault: str, rigid: bool, cause: str, most_n: float, tmp_path: Path) -> None:
    outcome = run_case(fault, "load", tmp_path, rigid=rigid)
    assert (outcome.told["how"], outcome.told["cause"]) == ("guard", cause)
    assert outcome.peak_n <= most_n
    assert outcome.guard_s is not None
    assert outcome.guard_s <= 0.01
    assert outcome.safe_s is not None
    assert outcome.next_run["how"] == "completed"


@pytest.mark.parametrize(
    ("wrong", "cause"), [("push_axis along x", "untrusted force"), ("home 9 mm too deep", "way home")]
)
def test_a_wrong_rig_file(wrong: str, cause: str, tmp_path: Path) -> None:
    outcome = run_wrong(wrong, tmp_path)
    assert (outcome.told["how"], outcome.told["cause"]) == ("guard", cause)
    assert outcome.peak_n <= MOST_N
    assert outcome.left_n == pytest.approx(0.0, abs=0.05)
    assert not (outcome.told["retracted"] and not outcome.retracted)
    assert replace(outcome, wanted=(("guard", cause),)).failures() == []  # type: ignore[arg-type]


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
