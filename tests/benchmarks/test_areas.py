"""Every area of ``emg2vsa tools bench`` at smoke size: errors and digits, never time."""

from __future__ import annotations

from functools import cache

import pytest

from benchmarks.areas import area, rig, runs
from benchmarks.bench.case import Size
from benchmarks.bench.measure import measure
from benchmarks.bench.results import AreaResult, CaseResult, Row

OURS = {
    "readers": {"EDF": 2e-5, "video": 0.0, "MATLAB": 0.0, "": 1e-7},
    "conditioning": {"raw EMG": 0.2, "": 1e-12},
    "segmentation": {"": 2.0},
    "records": {"": 0.02},
    "fits": {"intervals of b": 20.0, "MGH10": 3e-10, "DanWood": 1e-11, "": 1e-13},
    "tests": {
        "large samples": 0.0,
        "all pairs": 0.0,
        "Lilliefors": 0.15,
        "NIST AtmWtAg": 1e-10,
        "": 1e-12,
    },
    "calibration": {"intervals": 11.0, "": 0.06},
}
"""Largest error of ours by area and by a word of the case's name. Rank-deficient NIST sets lose what doubles lose."""
AGREE = {"readers": 2e-5, "conditioning": 1e-9, "segmentation": 2.0}
"""Areas whose other libraries must agree where they do equal work; whole records differ at their ends (MNE pads)."""


@cache
def smoke(name: str) -> AreaResult:
    # the libraries beside the tests alone take ten seconds: they run among the slow tests
    return measure(area(name), Size.SMOKE, rounds=0, ours_alone=name == "tests")


def _rows(result: AreaResult) -> list[tuple[CaseResult, Row]]:
    return [(case, row) for case in result.cases for row in case.rows]


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", OURS)
def test_errors_of_ours_are_bounded(name: str) -> None:
    bounds = OURS[name]
    result = smoke(name)
    assert result.cases
    for case, row in _rows(result):
        if row.ours:
            bound = next(limit for word, limit in bounds.items() if word in case.name)
            assert not row.failed, f"{case.name}, {row.label}: {row.failed}"
            assert row.error is not None
            assert row.error <= bound, f"{case.name}, {row.label}"


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", AGREE)
def test_equal_work_agrees(name: str) -> None:
    for case, row in _rows(smoke(name)):
        if row.work == "equal" and not row.failed and "whole records" not in case.name:
            assert row.error is not None
            assert row.error <= AGREE[name], f"{case.name}, {row.label}"


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_no_way_of_another_library_fails() -> None:
    for case, row in _rows(measure(area("tests"), Size.SMOKE, rounds=0)):
        assert not row.failed, f"{case.name}, {row.label}"


TACTILE = {
    "pins": {"": 0.5},
    "flow": {"casr": 0.5, "expert": 3.0, "DIS": 6.0},
    "growth": {"PyrLK": 1.0, "pin-affine": 1.0, "horn-schunck": 2.0, "dis": 8.0},
    "area": {"edge": 1.0, "": 2000.0},
    "scoring": {"front": 4.0, "": 150.0},
}
"""Largest size of an error, percent, by area and by a word of the way. Hexagons and skin are as wrong as those of
the paper."""


@pytest.mark.parametrize("name", TACTILE)
def test_errors_of_all_tactile_ways_are_bounded(name: str) -> None:
    cases = measure(area(name), Size.SMOKE, rounds=0).cases
    assert cases
    for row in (row for case in cases for row in case.rows):
        bound = next(limit for word, limit in TACTILE[name].items() if word in f"{row.library} {row.name}")
        assert not row.failed, f"{row.label}: {row.failed}"
        assert row.error is not None
        assert abs(row.error) <= bound, row.label


def test_an_emulated_run_goes_through_as_many_turns_either_way() -> None:
    (case,) = rig.turns(Size.SMOKE)
    assert case.size > 100
    assert [case.error_of(way, way.run()) for way in case.ways] == [0, 0, 0]


@pytest.mark.slow
def test_every_way_to_a_report_gives_the_same_numbers() -> None:
    (case,) = runs.people(Size.SMOKE)
    assert case.size == 6
    assert [case.error_of(way, way.run()) for way in case.ways] == [0, 0, 0, 0]
