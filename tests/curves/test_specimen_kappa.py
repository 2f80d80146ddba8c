"""kappa of a specimen: intervals over presses, mountings and castings hold what they say."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.curves.specimen_kappa import LEVELS, NestedMean, Spread, nested_mean

KAPPA = 5.0


def measured(rng: np.random.Generator, counts: tuple[int, int, int], spread: Spread) -> tuple[NestedMean, float, float]:
    """Of made presses, mountings and castings; and kappa of the mountings, and of the castings, as they truly are."""
    presses, mountings, castings = counts
    casting = KAPPA * (1 + spread.castings * rng.standard_normal(castings))
    mounting = casting[:, None] * (1 + spread.mountings * rng.standard_normal((castings, mountings)))
    press = mounting[..., None] * (1 + spread.presses * rng.standard_normal((castings, mountings, presses)))
    error = 0.002 * KAPPA
    values = press + error * rng.standard_normal(press.shape)
    at = np.indices(press.shape).reshape(3, -1).astype(str)
    found = nested_mean(values.ravel(), np.full(values.size, error), at[0].tolist(), at[1].tolist())
    return found, float(mounting.mean()), float(casting.mean())


@pytest.mark.parametrize("counts", [(1, 1, 1), (5, 1, 1), (5, 3, 1), (3, 2, 4), (1, 6, 1)])
@pytest.mark.parametrize(("times", "least"), [(0.5, 0.945), (1.0, 0.93), (1.4, 0.87)])
def test_intervals_hold_the_stated_spread_and_most_of_a_larger_one(
    counts: tuple[int, int, int], times: float, least: float
) -> None:
    rng, stated = np.random.default_rng(4), Spread()
    true = Spread(*(times * getattr(stated, level) for level in LEVELS))
    held = []
    for _ in range(1000):
        found, of_mountings, of_castings = measured(rng, counts, true)
        truths = (of_mountings, of_castings, KAPPA)
        held.append([abs(found.mean - truth) <= found.half(level) for level, truth in zip(LEVELS, truths, strict=True)])
    assert min(np.mean(held, axis=0)) >= least


def test_errors_of_one_press_are_the_stated_ones() -> None:
    found = nested_mean(np.array([2.0]), np.array([0.01]), ["A"], ["1"], Spread(0.01, 0.02, 0.05))
    presses, mountings, castings = found.error
    assert presses == pytest.approx(np.hypot(0.02, 0.01))
    assert mountings == pytest.approx(np.hypot(presses, 0.04))
    assert castings == pytest.approx(np.hypot(mountings, 0.1))
    np.testing.assert_allclose(found.steps, [0.02, 0.04, 0.1])
    assert found.count == (1, 1, 1)


def test_more_presses_of_one_mounting_never_tell_of_the_next() -> None:
    few, many = (nested_mean(np.full(n, 3.0), np.zeros(n), ["A"] * n, ["1"] * n) for n in (2, 200))
    assert many.error[0] < 0.15 * few.error[0]
    assert many.error[1] > 0.95 * 0.02 * 3
    assert many.error[2] > 0.95 * np.hypot(0.02, 0.035) * 3


def test_many_castings_speak_for_themselves() -> None:
    values = KAPPA * (1 + 0.1 * np.random.default_rng(1).standard_normal(200))
    found = nested_mean(values, np.zeros(200), [str(i) for i in range(200)], ["1"] * 200)
    assert found.error[2] == pytest.approx(values.std(ddof=1) / np.sqrt(200), rel=0.05)
    assert found.count == (200, 200, 200)


def test_castings_that_do_not_differ_by_decree_add_nothing() -> None:
    found = nested_mean(np.array([3.0, 3.01]), np.zeros(2), ["A"] * 2, ["1"] * 2, Spread(castings=0.0))
    assert found.error[2] == pytest.approx(found.error[1])


def test_no_press_gives_no_number() -> None:
    found = nested_mean(np.empty(0), np.empty(0), [], [])
    assert np.isnan([found.mean, found.half()]).all()
    assert found.count == (0, 0, 0)


def test_a_mounting_with_one_press_borrows_the_scatter_of_the_others() -> None:
    rng, held = np.random.default_rng(3), []
    mountings = ["1"] * 6 + ["2"]
    for _ in range(1000):  # presses scatter by three times the stated spread
        values = KAPPA * (1 + 0.03 * rng.standard_normal(7))
        found = nested_mean(values, np.zeros(7), ["A"] * 7, mountings)
        assert found.mean == pytest.approx((values[:6].mean() + values[6]) / 2)
        held.append(abs(found.mean - KAPPA) <= found.half("presses"))
    assert np.mean(held) > 0.88
