"""The total interval of a rate: its parts together, and its extremes."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from casr.spread.total import total_interval


def test_it_reaches_as_far_as_its_parts_together() -> None:
    found = total_interval(10.0, {"scatter": 0.03, "dome": 0.04})
    assert found is not None
    assert (found.low, found.high) == pytest.approx((10 / np.exp(1.959964 * 0.05), 10 * np.exp(1.959964 * 0.05)))


@pytest.mark.parametrize(("value", "part"), [(0.0, 0.1), (-1.0, 0.1), (np.nan, 0.1), (1.0, np.nan), (1.0, np.inf)])
def test_there_is_none_of_what_is_not_known(value: float, part: float) -> None:
    assert total_interval(value, {"scatter": 0.1, "dome": part}) is None


def test_a_part_that_says_nothing_leaves_everything_possible_without_a_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = total_interval(1.0, {"scatter": 1000.0})
    assert found is not None
    assert (found.low, found.high) == (0.0, np.inf)
