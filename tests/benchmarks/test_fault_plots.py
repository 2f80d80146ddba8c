"""Worst cases of the search for faults are pressed once more and drawn as the record names them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks.fault_plots import EACH, draw, trace, worst


def record(path: Path, *rows: tuple[str, str, str, str, str]) -> Path:
    path.write_text(json.dumps({"blocks": [{"rows": [[*row, "0.0"] for row in rows]}]}))
    return path


def test_the_worst_of_each_way_to_end_are_chosen_before_others(tmp_path: Path) -> None:
    alike = [("rigid", f"late {i}", "guard", "following", f"{20 - i}.0") for i in range(6)]
    whole = ("rigid", "weak 2; lag 3", "completed", "", "9.0")
    found = worst(record(tmp_path / "record.json", *alike, whole))
    assert [lines for _, lines, _ in found] == [("late 0",), ("late 1",), ("late 2",), ("weak 2", "lag 3")]
    assert len(found) == EACH


def test_a_fault_is_marked_from_its_force_on_for_as_long_as_it_lasts() -> None:
    traced = trace("rigid", ("weak 0.9 at 2 N for 0.1 s", "drift 1 at 90 N", "lag 1 at 0.5 s"), 0.0)
    (begun_s, over_s), (lag_s, end_s) = traced.faults
    at_n = dict(zip(traced.true_s, traced.true_n, strict=True))
    assert at_n[begun_s] >= 2 > max(n for s, n in at_n.items() if s < begun_s)
    assert over_s == pytest.approx(begun_s + 0.1)
    assert (lag_s, end_s) == (0.5, traced.true_s[-1])
    assert begun_s < traced.ended_s <= end_s
    assert max(traced.true_n) == traced.result.true_n
    assert max(traced.felt_n) > 6


def test_a_case_that_no_longer_presses_as_recorded_is_told(tmp_path: Path) -> None:
    case = ("rigid", "lag 1 at 0.5 s", "completed", "", "30.0")
    svg, png, told = draw(record(tmp_path / "record.json", case), tmp_path / "plots")
    assert Path(svg).stat().st_size > 0 < Path(png).stat().st_size
    assert told.startswith("rigid, lag 1 at 0.5 s: ")
    assert told.endswith(" N now, 30 N in the record")
