"""The areas of the tactile side, of the rig and of whole runs, at smoke size: errors, never time."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from benchmarks.areas import area, rig, runs
from benchmarks.bench import timing
from benchmarks.bench.case import Size
from benchmarks.bench.measure import measure
from benchmarks.bench.timing import processor_s

BOUNDS = {
    "pins": {"": 0.5},
    "flow": {"casr": 0.5, "Farneback": 1.0, "DIS": 6.0, "Jacobi": 20.0},
    "growth": {"pin-affine": 1.0, "horn-schunck": 2.0, "dis": 8.0},
    "area": {"edge": 1.0, "": 2000.0},
    "scoring": {"front": 4.0, "": 150.0},
}
"""Largest size of an error, percent, by area and by a word of the way. Hexagons and skin are as wrong as those of
the paper."""


@pytest.mark.parametrize("name", BOUNDS)
def test_errors_of_all_ways_are_bounded(name: str) -> None:
    cases = measure(area(name), Size.SMOKE, rounds=0).cases
    assert cases
    for row in (row for case in cases for row in case.rows):
        bound = next(limit for word, limit in BOUNDS[name].items() if word in f"{row.library} {row.name}")
        assert not row.failed, f"{row.label}: {row.failed}"
        assert row.error is not None
        assert abs(row.error) <= bound, row.label


def test_lucas_and_kanade_do_the_work_of_ours() -> None:
    for case in measure(area("pins"), Size.SMOKE, rounds=0).cases:
        work = {row.name: row.work for row in case.rows}
        assert work["pins followed"] == work["PyrLK on all pins, default"] == "equal"
        assert work["PyrLK on the contact's pins"] == "as used"


def test_an_emulated_run_goes_through_as_many_turns_either_way() -> None:
    (case,) = rig.turns(Size.SMOKE)
    assert case.size > 100
    assert [case.error_of(way, way.run()) for way in case.ways] == [0, 0]


@pytest.mark.slow
def test_the_beat_of_the_loop_has_a_period_error() -> None:
    (case,) = rig.beat(Size.SMOKE)
    for way in case.ways:
        error = case.error_of(way, way.run())
        assert error is not None
        assert 0 < error < 1e3


def test_start_up_ends_well() -> None:
    (case,) = runs.start_up(Size.SMOKE)
    ours, floor = case.ways[0], next(way for way in case.ways if way.name == "pass")
    assert [case.error_of(way, way.run()) for way in (ours, floor)] == [0, 0]


@pytest.mark.slow
def test_every_way_to_a_report_gives_the_same_numbers() -> None:
    (case,) = runs.people(Size.SMOKE)
    assert case.size == 6
    assert [case.error_of(way, way.run()) for way in case.ways] == [0, 0, 0]


def test_numbers_that_differ_are_counted() -> None:
    kept = {"a": 1.0, "b": [1, 2], "c": {"d": np.pi}}
    assert runs.differing(kept, kept) == 0
    assert runs.differing({"a": 1.0, "b": [1, 3], "c": {}}, kept) == 2
    assert runs.differing({**kept, "e": 1}, kept) == 1
    assert runs.differing({"a": 1.0, "b": [1], "c": kept["c"]}, kept) == 1


@pytest.mark.skipif(os.name != "posix", reason="the time of children that ended is known on POSIX systems alone")
def test_the_clock_counts_children_that_have_ended(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    before = processor_s()
    runs.python("-c", "sum(range(2_000_000))")
    spent = processor_s() - before
    monkeypatch.setattr(timing, "_ended_children_s", lambda: 0.0)
    before = processor_s()
    runs.python("-c", "sum(range(2_000_000))")
    assert processor_s() - before < spent
