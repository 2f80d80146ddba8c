"""The worst cases of the Dynamixel's fault matrix, and a few of the others: the whole of it is
``python -m benchmarks.dynamixel_faults``."""

from __future__ import annotations

import json
import random
import sys
from pathlib import Path

import pytest

from benchmarks import dynamixel_faults as matrix
from benchmarks.dynamixel_faults import LIMIT_N, Case, carry_out, cases
from benchmarks.rig.dynamixel_faults import cap_n
from benchmarks.rig.fault_case import TOP, WHOLE_RUN

WORST = [
    Case("encoder reads 90 degrees less", "escape"),
    Case("encoder frozen", TOP),
    Case("encoder frozen", "load", specimen="S3"),
    Case("gear jammed", "load"),
    Case("force axis dead", "load"),
    Case("force lags 100 ms", "load"),
    Case("program killed", TOP),
    Case("overload told", "load"),
    Case("push_sign upside down", WHOLE_RUN),
]
FEW = random.Random(30).sample([case for case in cases() if case not in WORST], 6)


@pytest.mark.parametrize("case", [*WORST, *FEW], ids=lambda case: ", ".join(map(str, case)))
def test_a_fault_ends_as_it_must(case: Case) -> None:
    row = carry_out(case)
    assert row["fails"] == []
    assert row["peak_n"] <= LIMIT_N
    assert row["next_run"] == "completed"


def test_a_motor_that_its_watchdog_has_stopped_holds_what_it_presses() -> None:
    row = carry_out(Case("program killed", "load"))
    assert not row["off"]
    assert row["left_n"] > 1
    assert row["safe_ms"] == pytest.approx(500, abs=30)


def test_the_goal_current_caps_the_force() -> None:
    assert cap_n(0.4) == pytest.approx(15.6, abs=0.05)
    assert cap_n(0.25) < LIMIT_N


def test_what_is_there_is_not_done_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(matrix, "PROCESSES", 1)
    monkeypatch.setattr(sys, "argv", ["dynamixel_faults", "gear jammed", "--phase", "load", "--write", str(tmp_path)])
    matrix.main()
    assert (
        capsys.readouterr().out.count("gear jammed") == 5 + 5
    )  # at each goal current and on each specimen, and in its sum
    rows = json.loads((tmp_path / matrix.RESULTS).read_text())
    assert [(row["goal_a"], row["specimen"]) for row in rows] == [
        (0.4, "S1"), (0.3, "S1"), (0.25, "S1"), (0.4, "S3"), (0.4, "S5"),
    ]  # fmt: skip
    assert "| gear jammed | 1 |" in (tmp_path / "dynamixel_faults.md").read_text()
    matrix.main()
    assert capsys.readouterr().out.count("gear jammed") == 5
    assert json.loads((tmp_path / matrix.RESULTS).read_text()) == rows
