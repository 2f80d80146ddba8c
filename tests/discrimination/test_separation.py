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
from scipy import stats
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.weightstats import ttost_ind

from emg2vsa.discrimination import discriminate
from emg2vsa.discrimination.mountings import Mountings
from emg2vsa.discrimination.separation import closest_pair, gap_of, gaps_of, press_sds, pressed_everywhere, sd_ratio
from emg2vsa.run_scores import RunScores
from emg2vsa.settings import DiscriminationSettings
from tests.rig_worlds import drawn, numbers

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


def mounted(rng, truth, mountings=3, presses=3, **scatter):
    scores = drawn(rng, np.asarray(truth), mountings=mountings, presses=presses, **scatter)
    return Mountings.of(scores, numbers(scores.shape[:2], mountings, presses), 0.043)


def test_a_gap_is_the_contrast_over_mountings_in_sds_of_a_press():
    rng = np.random.default_rng(0)
    scores = drawn(rng, np.array([[0.0, 0.1], [0.1, 0.0]]), mountings=3, presses=4)
    found = gaps_of(Mountings.of(scores, numbers((2, 2), 3, 4), 0.043), (0, 1), 0.95)
    logs = np.log(scores).reshape(2, 2, 3, 4)
    for design in range(2):
        contrast = logs[design, 1].mean() - logs[design, 0].mean()
        sd = np.sqrt(logs[design].var(axis=2, ddof=1).mean())
        assert found.gap[design] == pytest.approx(abs(contrast) / sd)
        assert 0 <= found.low[design] < found.gap[design] < found.high[design]


def test_no_scatter_of_presses_and_no_press_have_no_gap():
    rng = np.random.default_rng(1)
    lost = drawn(rng, np.zeros((1, 2)))
    lost[0, 1] = np.nan
    for scores, presses in ((drawn(rng, np.zeros((1, 2)), presses=1), 1), (lost, 3)):
        found = gaps_of(Mountings.of(scores, numbers((1, 2), 3, presses), 0.043), (0, 1), 0.95)
        assert np.isnan([found.gap, found.low, found.high]).all()
    alike = mounted(rng, np.zeros((1, 2)), press_sd=0.0)
    assert not np.isfinite(gap_of(alike, 0, (0, 1), 0.95)[2]) or press_sds(alike)[0] > 0  # rounding alone


@pytest.mark.parametrize("mountings", [1, 3])
@pytest.mark.parametrize("gap", [0.5, 8.0])
def test_intervals_of_gaps_and_of_their_differences_hold_the_truth_as_often_as_they_promise(gap, mountings):
    rng, tries, presses = np.random.default_rng(0), 400, 12 // mountings
    held, differ = 0, 0
    for _ in range(tries):
        world = mounted(rng, [[0.0, 0.02 * gap]] * 2, mountings, presses, mounting_sd=0.043, press_sd=0.02)
        found = gaps_of(world, (0, 1), 0.95)
        held += np.count_nonzero((found.low <= gap) & (gap <= found.high))
        difference = found.at(np.array([0])).less(found.at(np.array([1])))
        differ += int(difference.low[0] <= 0 <= difference.high[0])
    assert held >= stats.binom.ppf(0.001, 2 * tries, 0.945)
    assert differ >= stats.binom.ppf(0.001, tries, 0.945)
    assert held <= 0.995 * 2 * tries  # no interval so wide that it tells nothing


def test_a_difference_is_that_of_the_gaps_and_turns_with_them():
    found = gaps_of(mounted(np.random.default_rng(2), [[0.0, 0.1], [0.0, 0.3]]), (0, 1), 0.95)
    one, other = found.at(np.array([0])), found.at(np.array([1]))
    there, back = one.less(other), other.less(one)
    assert there.gap == pytest.approx(one.gap - other.gap)
    assert (there.low[0], there.high[0]) == pytest.approx((-back.high[0], -back.low[0]))


def test_the_closest_pair_is_that_of_the_most_alike_stiffness_whatever_the_scores():
    assert closest_pair(np.array([7.63, 5.32, 3.35, 1.11]), range(4)) == (0, 1)
    assert closest_pair(np.array([7.63, 5.32, 3.35, 1.11]), [0, 2, 3]) == (0, 2)
    assert closest_pair(np.array([7.63, 3.35, 3.12]), [2, 1, 0]) == (1, 2)


def test_sds_of_presses_are_those_within_mountings_and_their_ratio_has_an_interval_by_f():
    rng = np.random.default_rng(3)
    scores = drawn(rng, np.zeros((2, 3)), mounting_sd=0.5, press_sd=np.array([[0.04], [0.01]]))
    world = Mountings.of(scores, numbers((2, 3), 3, 3), 0.043)
    first, second = np.sqrt(np.log(scores).reshape(2, 9, 3).var(axis=2, ddof=1).mean(axis=1))
    assert press_sds(world) == pytest.approx([first, second])
    ratio, low, high = sd_ratio(world, 0, 1, 0.95)
    assert ratio == pytest.approx(first / second)
    assert (ratio / low) ** 2 == pytest.approx(stats.f.ppf(0.975, 18, 18))
    assert (high / ratio) ** 2 == pytest.approx(stats.f.ppf(0.975, 18, 18))
    assert np.isnan(sd_ratio(mounted(rng, np.zeros((2, 3)), presses=1), 0, 1, 0.95)).all()


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
