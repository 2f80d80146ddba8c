"""Intervals of mean coefficients: equal to textbook formulas, and as often right as they say in worlds that differ."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import stats

from benchmarks.interval_coverage import ALL, SERIAL, World, covered, presses
from emg2vsa.profiles import build_profiles, errors_of, mean_errors
from emg2vsa.settings import ProfileSettings, WindowSettings
from tests.test_profiles import STIFFNESS, fits_of

NAMES = ("S1", "S3", "S5")
B_OF_S1 = np.zeros((1, 3, 2))
B_OF_S1[0, 0, 1] = 1


def values(seed: int = 1, n: int = 10) -> np.ndarray:
    return 20 + np.random.default_rng(seed).standard_normal((3, n, 2))


def test_one_mean_over_presses_has_students_interval() -> None:
    x = values()
    errors = errors_of(x, NAMES, "press")
    assert errors.rho == 0
    expected = stats.t.interval(0.95, 9, x[0, :, 1].mean(), stats.sem(x[0, :, 1]))
    assert_allclose(errors.half_width(B_OF_S1), (expected[1] - expected[0]) / 2, rtol=1e-12)


def test_a_difference_of_two_specimens_has_welchs_interval_over_presses_and_the_paired_one_over_people() -> None:
    x = values()
    x[1] *= 3
    weights = np.zeros((1, 3, 2))
    weights[0, :2, 0] = 1, -1
    found = stats.ttest_ind(x[0, :, 0], x[1, :, 0], equal_var=False).confidence_interval()
    assert_allclose(errors_of(x, NAMES, "press").half_width(weights), (found.high - found.low) / 2, rtol=1e-12)
    found = stats.ttest_rel(x[0, :, 0], x[1, :, 0]).confidence_interval()
    assert_allclose(errors_of(x, NAMES, "person").half_width(weights), (found.high - found.low) / 2, rtol=1e-12)


def test_gaps_leave_the_presses_that_are_there() -> None:
    x = values()
    x[0, [2, 7]] = np.nan
    errors = errors_of(x, NAMES, "press")
    there = x[0, np.isfinite(x[0, :, 1]), 1]
    assert errors.count.tolist() == [8, 10, 10]
    assert_allclose(errors.half_width(B_OF_S1), stats.t.ppf(0.975, 7) * stats.sem(there), rtol=1e-12)


@pytest.mark.parametrize("unit", ["press", "person"])
def test_what_was_drawn_once_has_no_interval(unit: str) -> None:
    x = values()
    x[0, 1:] = np.nan
    other = np.roll(B_OF_S1, 1, axis=1)
    found = errors_of(x, NAMES, unit).half_width(np.concatenate([B_OF_S1, B_OF_S1 + other, other]))  # type: ignore[arg-type]
    assert np.isfinite(found).tolist() == [False, False, True]


@pytest.mark.parametrize("unit", ["press", "person"])
def test_equal_presses_have_an_interval_of_no_width(unit: str) -> None:
    x = np.broadcast_to([0.1, 0.3], (3, 10, 2)).copy()
    assert errors_of(x, NAMES, unit).half_width(B_OF_S1)[0] == pytest.approx(0, abs=1e-15)  # type: ignore[arg-type]


def test_presses_that_drift_widen_the_interval_and_lose_degrees_of_freedom() -> None:
    x = values(n=12)
    drifting = x + np.linspace(-2, 2, 12)[None, :, None]
    alike = errors_of(drifting, NAMES, "press")
    assert alike.rho > 0.3
    plain = stats.t.ppf(0.975, 11) * stats.sem(drifting[0, :, 1])
    assert alike.half_width(B_OF_S1)[0] > 1.5 * plain
    assert errors_of(drifting, NAMES, "person").rho == 0  # people have no order


def test_the_unit_of_volts_does_not_matter() -> None:
    x = values()
    weights = np.random.default_rng(2).standard_normal((4, 3, 2))
    for unit in ("press", "person"):
        micro, plain = (errors_of(scale * x, NAMES, unit).half_width(weights) for scale in (1e-200, 1.0))  # type: ignore[arg-type]
        assert_allclose(micro / 1e-200, plain, rtol=1e-9)


def test_people_of_unequal_presses_weigh_by_them_only_in_the_mean_over_presses() -> None:
    rows = [("P1", "S1", 1.0, 1.0), *[("P2", "S1", 2.0, 4.0)] * 3, ("P3", "S1", 3.0, 4.0)]
    fits = fits_of(rows)
    every = np.ones(5, dtype=bool)
    alike = mean_errors(fits, every, ["S1"], "person").half_width(B_OF_S1[:, :1])
    assert_allclose(alike, stats.t.ppf(0.975, 2) * stats.sem([1, 4, 4]), rtol=1e-12)
    by_press = mean_errors(fits, every, ["S1"], "person", presses_weigh=True).half_width(B_OF_S1[:, :1])
    shares = np.array([1 - 3.4, 3 * (4 - 3.4), 4 - 3.4]) / 5
    assert_allclose(by_press, stats.t.ppf(0.975, 2) * np.sqrt(1.5 * np.sum(shares**2)), rtol=1e-12)


@pytest.mark.parametrize("rule", ["bracket", "paper", "log-stiffness", "coefficients"])
def test_an_interpolated_profile_has_the_errors_of_those_it_is_made_of(rule: str) -> None:
    rng = np.random.default_rng(5)
    rows = [("P1", s, 5 * k + rng.normal(), 2 * k + rng.normal()) for s, k in STIFFNESS.items() for _ in range(6)]
    settings = ProfileSettings(
        specimens=("S1", "S3", "S4", "S5"),
        new_specimen="S_new",
        new_stiffness_n_per_mm=5.32,
        interpolation=rule,  # type: ignore[arg-type]
    )

    def new(rows: list[tuple[str, str, float, float]]) -> tuple[np.ndarray, np.ndarray]:
        found = build_profiles(fits_of(rows), STIFFNESS, settings, WindowSettings(), "ok")
        assert found.new is not None
        return found.new.v, found.half_width_v(found.new)

    v, half = new(rows)
    moved = [new([(p, s, a + 1e-5 * (s == name), b) for p, s, a, b in rows])[0] - v for name in STIFFNESS]
    found = build_profiles(fits_of(rows), STIFFNESS, settings, WindowSettings(), "ok")
    assert found.new is not None
    assert_allclose(np.mean(moved, axis=1) / 1e-5, found.new.weights[:, 0], atol=1e-4)
    assert np.all(half > 0)


@pytest.mark.parametrize(("people", "n", "world"), [
    (1, 10, ALL[3]), (1, 10, SERIAL[0]), (14, 10, ALL[1]),
    *(pytest.param(*case, marks=pytest.mark.slow) for case in (
        (1, 10, ALL[0]), (1, 5, ALL[1]), (1, 5, ALL[5]), (1, 10, ALL[6]), (1, 5, SERIAL[0]), (5, 10, ALL[3]),
    )),
])  # fmt: skip
def test_intervals_hold_the_truth_as_often_as_they_say(people: int, n: int, world: World) -> None:
    """300 studies: the mean over specimens, forces or steps is known within 2 points."""
    *cells, _ = covered(world, people, n, 300)
    for cell in cells:
        assert 92 <= float(cell.split(" ")[0]) <= 98.5


def test_without_the_widening_correlated_presses_would_be_missed() -> None:
    """What the test above can tell: intervals of independent presses hold the truth in 75 % of such studies."""
    rng, held = np.random.default_rng(8), []
    for _ in range(200):
        x = presses(SERIAL[0], 1, 10, rng)[0]
        errors = replace(
            errors_of(x, [*STIFFNESS], "press"), rho=0.0, influence=(x - x.mean(axis=1, keepdims=True)) / np.sqrt(90)
        )
        half = errors.half_width(np.eye(5)[:, :, None] * [0, 1])
        held.append(np.abs(x[..., 1].mean(axis=1) - np.array(SERIAL[0].truth)[:, 1]) <= half)
    assert np.mean(held) < 0.85
