"""Error measures against values worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.tactile.metrics import angular_error_deg, endpoint_error_px, pareto_front, percent_error, sample_sd


def test_endpoint_error_is_a_length() -> None:
    assert endpoint_error_px(np.array([[3.0, 4.0], [1.0, 1.0]]), np.array([[0.0, 0.0], [1.0, 1.0]])).tolist() == [5, 0]


@pytest.mark.parametrize(
    ("flow", "truth", "degrees"),
    [
        ((1, 0), (0, 0), 45.0),
        ((0, 0), (0, 0), 0.0),
        ((1, 0), (-1, 0), 90.0),
        ((1, 1), (-1, -1), np.degrees(np.arccos(-1 / 3))),
        ((1e-9, 0), (0, 0), np.degrees(1e-9)),
    ],
)
def test_angular_error_by_hand(flow: tuple[float, float], truth: tuple[float, float], degrees: float) -> None:
    assert angular_error_deg(np.array(flow), np.array(truth)) == pytest.approx(degrees, rel=1e-12)


def test_percent_error_and_spread() -> None:
    assert percent_error(np.array([0.9, 1.1]), 1.0) == pytest.approx([-10, 10])
    assert sample_sd(np.array([1.0, 3.0])) == pytest.approx(np.sqrt(2))
    assert sample_sd(np.array([1.0])) == 0


def test_pareto_front_by_hand() -> None:
    #       worse, fast,  equal, best,  dominated
    time = [2.0, 1.0, 1.0, 3.0, 3.5]
    error = [6.0, 5.0, 5.0, 1.0, 2.0]
    assert pareto_front(time, error) == [1, 3]


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), min_size=1, max_size=20))
def test_nothing_beats_the_pareto_front(points: list[tuple[int, int]]) -> None:
    time, error = zip(*points, strict=True)
    front = pareto_front(time, error)
    for i, (t, e) in enumerate(points):
        beaten = any(u <= t and f <= e and (u, f) != (t, e) for u, f in points)
        assert (i in front) <= (not beaten)
        assert beaten or any((time[j], error[j]) == (t, e) for j in front)
