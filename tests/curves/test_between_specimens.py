"""Neighbours and weights of the interpolation between specimens."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.errors import DataError
from emg2vsa.profiles.interpolation import between, softer_weight

STIFFNESS = np.array([1.0, 4.0, 2.0, 4.0])
VALUES = np.array([[10.0], [40.0], [20.0], [99.0]])


@pytest.mark.parametrize(
    ("k", "stiffer", "softer", "value"),
    [(1.0, 2, 0, 10), (1.5, 2, 0, 15), (2.0, 1, 2, 20), (3.0, 1, 2, 30), (4.0, 1, 2, 40)],
)
def test_nearest_neighbours_in_any_order_and_the_first_of_equals(
    k: float, stiffer: int, softer: int, value: float
) -> None:
    made = between(STIFFNESS, VALUES, k, "bracket", extrapolate=False, where="here")
    assert (made.stiffer, made.softer) == (stiffer, softer)
    np.testing.assert_array_equal(made.values, [value])


@pytest.mark.parametrize("known", [[], [3.0], [3.0, 3.0]])
def test_one_stiffness_is_not_enough(known: list[float]) -> None:
    with pytest.raises(DataError, match=r"here: expected two specimens .* found [01]\."):
        between(np.array(known), np.zeros((len(known), 2)), 3.0, "bracket", extrapolate=True, where="here")


@pytest.mark.parametrize("method", ["bracket", "log-stiffness"])
def test_weight_is_exact_at_both_ends(method: str) -> None:
    rng = np.random.default_rng(1)
    for softer, stiffer in np.sort(rng.uniform(0.1, 20, (200, 2)), axis=1):
        assert softer_weight(stiffer, stiffer, softer, method, "") == 0
        assert softer_weight(softer, stiffer, softer, method, "") == 1


def test_paper_weight_does_not_know_its_neighbours() -> None:
    assert {softer_weight(5.32, stiffer, 1.0, "paper", "") for stiffer in (6.0, 7.63, 30.0)} == {0.532}
