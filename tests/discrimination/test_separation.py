"""Tests of areas and rates against SciPy and statsmodels, which share no code with ours.

Condition, angle and specimen together, on the runs of the experiment.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from pingouin import compute_effsize
from scipy import stats
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.weightstats import ttost_ind

from emg2vsa.discrimination import discriminate
from emg2vsa.discrimination.separation import (
    closest_pair,
    cv_ratio,
    gaps_of,
    level_ratio,
    pressed_everywhere,
    repetition_cv,
    steps,
)
from emg2vsa.run_scores import RunScores
from emg2vsa.settings import DiscriminationSettings

KNOWN = ("S1", "S3", "S5")


@pytest.fixture(scope="module")
def found(runs, stiffness_n_per_mm):
    return discriminate(runs, stiffness_n_per_mm, "S_new")


@pytest.fixture(scope="module")
def scores(runs):
    """(quantity, condition, angle, specimen) to the presses, straight from the runs."""

    def of(quantity, condition, angle, specimen):
        run = next(r for r in runs if (r.condition, r.angle_deg, r.specimen) == (condition, angle, specimen))
        return getattr(run, quantity)["front"]

    return of


def dunn_by_hand(groups):
    """Pooled midranks, z of the difference of mean ranks, Bonferroni."""
    ranks = stats.rankdata(np.concatenate(groups))
    own = np.split(ranks, np.cumsum([len(g) for g in groups])[:-1])
    variance = np.var(ranks, ddof=1)
    pairs = list(combinations(own, 2))
    z = [(a.mean() - b.mean()) / np.sqrt(variance * (1 / len(a) + 1 / len(b))) for a, b in pairs]
    return np.minimum(2 * stats.norm.sf(np.abs(z)) * len(pairs), 1)


@pytest.mark.parametrize(("design", "of"), [(0, ("high-stiffness", 0)), (5, ("modular", 45)), (6, ("constant-min", 0))])
def test_known_specimens_as_scipy_tests_them(design, of, found, scores):
    areas = [scores("start_area", *of, specimen) for specimen in KNOWN]
    rates = [scores("casr", *of, specimen) for specimen in KNOWN]
    assert found.area.groups.kruskal.p[design] == pytest.approx(stats.kruskal(*areas).pvalue, rel=1e-12)
    assert found.spread.groups.kruskal.p[design] == pytest.approx(stats.kruskal(*rates).pvalue, rel=1e-12)
    assert found.spread.worst_p[design] == pytest.approx(dunn_by_hand(rates).max(), rel=1e-10)
    exact = [stats.mannwhitneyu(a, b, method="exact").pvalue for a, b in combinations(rates, 2)]
    assert found.spread.worst_p_holm[design] == pytest.approx(multipletests(exact, method="holm")[1].max(), rel=1e-10)
    assert found.spread.rises[design] == (rates[0].mean() < rates[1].mean() < rates[2].mean())


def test_equality_is_tested_on_shares_of_the_mean(found, scores):
    areas = [scores("start_area", "high-stiffness", 0, specimen) for specimen in KNOWN]
    relative = [area / np.mean(areas) for area in areas]
    theirs = [ttost_ind(a, b, -0.05, 0.05)[0] for a, b in combinations(relative, 2)]
    assert found.area.equality.worst_p[0] == pytest.approx(max(theirs))
    assert found.area.equality.shown[0] == sum(p < 0.05 for p in theirs)
    assert found.area.equality.pairs[0] == len(theirs)
    assert found.area.softest_over_stiffest[0] == pytest.approx(areas[2].mean() / areas[0].mean())


def test_equal_areas_are_shown_equal(run_of, stiffness_n_per_mm):
    rng = np.random.default_rng(3)
    runs = [
        replace(run_of(name, 0.0, "modular"), start_area={"front": 40 * (1 + 0.01 * rng.standard_normal(10))})
        for name in KNOWN
    ]
    found = discriminate(runs, stiffness_n_per_mm, "S_new")
    assert found.area.groups.kruskal.p[0] > 0.05
    assert (found.area.equality.worst_p < 0.05).all()
    assert (found.area.equality.shown == found.area.equality.pairs).all()
    assert found.area.groups.bayes.bf01[0] > 1


def test_angles_are_compared_pooled_and_specimen_by_specimen(found, scores):
    of = found.area_by_angle
    angles = [0.0, 30.0, 45.0]
    assert of.conditions == ("high-stiffness",) * 4 + ("modular",) * 4
    assert of.specimens == ("", *KNOWN) * 2
    pooled = [np.concatenate([scores("start_area", "modular", angle, s) for s in KNOWN]) for angle in angles]
    alone = [scores("start_area", "modular", angle, "S3") for angle in angles]
    assert of.worst_p(4) == pytest.approx(dunn_by_hand(pooled).max(), rel=1e-10)
    assert of.worst_p(6) == pytest.approx(dunn_by_hand(alone).max(), rel=1e-10)
    assert of.groups.kruskal.p[6] == pytest.approx(stats.kruskal(*alone).pvalue, rel=1e-12)
    assert of.falls(6)
    assert not replace(of, mean=of.mean[:, ::-1]).falls(6)


def test_the_new_specimen_beside_its_neighbours(found, scores):
    new = found.new
    assert (new.name, new.neighbours) == ("S_new", ("S1", "S3"))
    for design, of in ((3, ("modular", 0)), (6, ("constant-min", 0))):
        own, stiffer, softer = (scores("casr", *of, name) for name in ("S_new", "S1", "S3"))
        exact = [stats.mannwhitneyu(own, other, method="exact").pvalue for other in (stiffer, softer)]
        assert new.p[design].tolist() == pytest.approx(multipletests(exact, method="holm")[1].tolist(), rel=1e-10)
        shift = [np.median(own[:, None] - other) for other in (stiffer, softer)]
        assert new.shift[design].tolist() == pytest.approx(shift)
        assert (new.low[design] <= shift).all()
        assert (new.high[design] >= shift).all()
        everyone = [scores("casr", *of, name) for name in ("S1", "S_new", "S3", "S5")]
        dunn = dunn_by_hand(everyone)  # pairs 01 02 03 12 13 23
        assert new.p_mean_rank[design].tolist() == pytest.approx([dunn[0], dunn[3]], rel=1e-10)
    assert new.between.all()
    assert new.discriminated.tolist() == [True] * 6 + [False, True, True]


@pytest.mark.parametrize(("new", "neighbours"), [("S5", ("S3", "")), ("S1", ("", "S_new"))])
def test_a_new_specimen_at_the_end_has_one_neighbour_and_lies_between_nothing(
    new, neighbours, runs, stiffness_n_per_mm
):
    found = discriminate(runs, stiffness_n_per_mm, new, DiscriminationSettings(resamples=50))
    assert found.new.neighbours == neighbours
    there = [bool(name) for name in neighbours]
    assert np.isfinite(found.new.p).all(axis=0).tolist() == there
    assert np.isfinite(found.new.p_mean_rank).all(axis=0).tolist() == there
    assert not found.new.discriminated.any()


SCORES = np.array([[1.0, 2.0, 3.0], [5.0, 6.0, 7.0], [8.0, 10.0, 12.0]])


def test_steps_are_cohens_d_of_neighbours():
    # (6 - 2) / 1 and (10 - 6) / sqrt((2 + 8) / 4)
    assert steps(SCORES).tolist() == pytest.approx([4, 4 / np.sqrt(2.5)])
    assert steps(SCORES[[1, 0, 2]])[0] == pytest.approx(-4)


def test_missing_presses_are_left_out():
    padded = np.concatenate([SCORES, np.full((3, 2), np.nan)], axis=1)
    assert np.array_equal(steps(padded), steps(SCORES))
    assert repetition_cv(padded) == repetition_cv(SCORES)


def test_a_gap_is_hedges_g():
    found = gaps_of(SCORES[None, :2], 0.95)
    expected = compute_effsize(SCORES[1], SCORES[0], eftype="hedges")  # approximates the factor: 1 - 3 / (4 n - 9)
    assert found.gap[0] == pytest.approx(expected, rel=0.005)
    assert found.low[0] < found.gap[0] < found.high[0]


@pytest.mark.parametrize(
    "pair",
    [
        [[1.0, 1.0], [2.0, 2.0]],
        [[1.0, 2.0], [np.nan, np.nan]],
        [[1.0, np.nan], [2.0, np.nan]],
        [[np.nan, np.nan], [np.nan, np.nan]],
    ],
)
def test_no_spread_and_no_press_have_no_gap(pair):
    found = gaps_of(np.array([pair]), 0.95)
    assert np.isnan([found.gap, found.low, found.high]).all()


@pytest.mark.parametrize("gap", [0.5, 8.0])
def test_intervals_of_gaps_and_of_their_differences_hold_the_truth_as_often_as_they_promise(gap):
    rng = np.random.default_rng(0)
    first, second = (rng.normal([[0.0], [gap]], 1.0, (300, 2, 10)) for _ in range(2))
    ours, other = gaps_of(first, 0.95), gaps_of(second, 0.95)
    difference = ours.less(other)
    assert np.mean((ours.low <= gap) & (gap <= ours.high)) == pytest.approx(0.95, abs=0.025)
    assert np.mean((difference.low <= 0) & (difference.high >= 0)) == pytest.approx(0.95, abs=0.025)
    assert np.mean(ours.gap) == pytest.approx(gap, rel=0.02, abs=0.03)


def test_a_difference_is_that_of_the_gaps_and_turns_with_them():
    found = gaps_of(np.stack([SCORES[:2], SCORES[1:]]), 0.95)
    one, other = found.at(np.array([0])), found.at(np.array([1]))
    there, back = one.less(other), other.less(one)
    assert there.gap == pytest.approx(one.gap - other.gap)
    assert (there.low[0], there.high[0]) == pytest.approx((-back.high[0], -back.low[0]))


def test_the_closest_pair_is_that_of_the_usual_design():
    values = np.stack([SCORES, SCORES, SCORES[[0, 0, 2]]])
    assert closest_pair(values) == 1
    assert closest_pair(np.full((2, 3, 4), np.nan)) == 0


def test_cv_is_the_root_mean_square_over_specimens():
    cvs = [1 / 2, 1 / 6, 2 / 10]
    assert repetition_cv(SCORES) == pytest.approx(np.sqrt(np.mean(np.square(cvs))))


def test_halves_are_compared():
    wider = np.concatenate([SCORES, SCORES + 2 * (SCORES - SCORES.mean(axis=1, keepdims=True))])
    assert cv_ratio(wider) == pytest.approx(1 / 3)
    assert level_ratio(np.concatenate([SCORES, 2 * SCORES])) == pytest.approx(0.5)
    assert np.isnan(level_ratio(np.concatenate([SCORES, -SCORES])))


def test_batches_are_what_single_designs_are():
    batch = np.stack([SCORES, SCORES**2, SCORES[::-1]])
    for statistic in (steps, repetition_cv):
        assert np.allclose(statistic(batch), [statistic(each) for each in batch])


def test_only_specimens_of_every_design_are_compared():
    values = np.ones((3, 3, 4))
    values[1, 1] = np.nan  # not pressed there
    values[2] = np.nan  # a design without any score rules nothing out
    assert pressed_everywhere(values).tolist() == [0, 2]
    values[1, 2] = np.nan
    assert pressed_everywhere(values).tolist() == [0, 1, 2]


def test_the_experiments_factors(runs: tuple[RunScores, ...], stiffness_n_per_mm: dict[str, float]) -> None:
    """CASR rises with softness and falls with the angle, in every condition alike: what the made runs hold."""
    factors = discriminate(runs, stiffness_n_per_mm, "S_new").factors
    assert factors.not_positive == (0, 0)
    assert factors.constant == ()
    for found in (factors.casr, factors.area):
        assert found is not None
        assert found.error_df == 270 - 27  # constant stiffness at one angle only: 18 of 45 cells are empty
        at = {name: i for i, name in enumerate(found.effects)}
        assert found.p[at["specimen"]] < 1e-50
        assert found.p[at["angle"]] < 1e-50
        assert found.omega2[at["specimen"]] > 0.9
        assert found.omega2[at["condition × angle × specimen"]] < 0.1
        assert (found.low <= found.omega2).all()
        assert (found.omega2 <= found.high).all()


def test_one_angle_is_no_factor(run_of: Callable[..., RunScores], stiffness_n_per_mm: dict[str, float]) -> None:
    runs = [run_of(s, 0.0, c) for c in ("high-stiffness", "modular") for s in ("S1", "S3", "S5")]
    factors = discriminate(runs, stiffness_n_per_mm, "S_new").factors
    assert factors.constant == ("angle",)
    assert factors.casr is not None
    assert factors.casr.effects == ("condition", "specimen", "condition × specimen")


def test_scores_without_a_logarithm_are_counted(
    run_of: Callable[..., RunScores], stiffness_n_per_mm: dict[str, float]
) -> None:
    runs = [run_of(s, 0.0, "modular") for s in ("S1", "S3", "S5")]
    casr = {name: values.copy() for name, values in runs[0].casr.items()}
    casr["front"][:2] = [-1e-3, 0.0]
    runs[0] = dataclasses.replace(runs[0], casr=casr)
    factors = discriminate(runs, stiffness_n_per_mm, "S_new").factors
    assert factors.not_positive == (0, 2)
    assert factors.casr is not None
    assert factors.casr.error_df == 28 - 3
    assert factors.area is not None
    assert factors.area.error_df == 30 - 3


@pytest.mark.parametrize("presses", [0, 1])
def test_runs_that_bear_no_model_have_none(
    run_of: Callable[..., RunScores], stiffness_n_per_mm: dict[str, float], presses: int
) -> None:
    runs = [run_of(s, 0.0, "modular", presses=1) for s in ("S1", "S3")]
    if not presses:
        runs = [dataclasses.replace(run, verdicts=("rejected",)) for run in runs]
    factors = discriminate(runs, stiffness_n_per_mm, "S_new").factors
    assert factors.casr is None
    assert factors.area is None
    assert np.all(np.array(factors.not_positive) == 0)


def test_claims_have_the_largest_p_of_what_they_need(
    runs: tuple[RunScores, ...], stiffness_n_per_mm: dict[str, float]
) -> None:
    found = discriminate(runs, stiffness_n_per_mm, "S_new")
    claims = list(found.claims.values())
    assert claims[1] == np.max(found.spread.worst_p)
    assert claims[0] == np.max(found.spread.groups.kruskal.p)
    assert all(0 <= p <= 1 for p in claims)
