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

from emg2vsa.discrimination import discriminate
from emg2vsa.discrimination.mountings import Mountings
from emg2vsa.discrimination.separation import closest_pair, gap_of, gaps_of, press_sds, pressed_everywhere, sd_ratio
from emg2vsa.run_scores import RunScores
from emg2vsa.settings import DiscriminationSettings
from tests.rig_worlds import drawn, numbers

KNOWN = ("S1", "S3", "S5")


@pytest.fixture(scope="module")
def found(runs, stiffness_n_per_mm):
    """Pressed at one place, so that nothing is drift."""
    at_once = [replace(run, pressed_at=1.0 + 1e-9 * i + 0 * run.pressed_at) for i, run in enumerate(runs)]
    return discriminate(at_once, stiffness_n_per_mm, "S_new", mounting_sd=0.025)


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
    assert found.area.kruskal.p[design] == pytest.approx(stats.kruskal(*areas).pvalue, rel=1e-12)
    assert found.spread.kruskal.p[design] == pytest.approx(stats.kruskal(*rates).pvalue, rel=1e-12)
    assert found.spread.worst_p[design] == pytest.approx(dunn_by_hand(rates).max(), rel=1e-10)
    assert found.spread.rises[design] == (rates[0].mean() < rates[1].mean() < rates[2].mean())


def test_ratios_are_over_mountings(found, scores):
    areas = [scores("start_area", "high-stiffness", 0, specimen) for specimen in KNOWN]
    ratio, logs = found.area.softest_over_stiffest, [np.log(area).mean() for area in areas]
    assert ratio.estimate[0] == pytest.approx(np.exp(logs[2] - logs[0]))
    # mounted once: 95 % of an SD of 2.5 % between mountings of each of two specimens
    assert np.log(ratio.high[0] / ratio.low[0]) > 2 * 1.96 * 0.025 * np.sqrt(2)
    steps, design = found.spread.steps, 3
    rates = [np.log(scores("casr", "modular", 0, name)).mean() for name in ("S1", "S_new", "S3", "S5")]
    assert steps.estimate[3 * design : 3 * design + 3] == pytest.approx(np.exp(np.diff(rates)))


def test_angles_are_compared_by_the_papers_test_and_over_mountings(found, scores):
    of = found.area_by_angle
    angles = [0.0, 30.0, 45.0]
    assert of.conditions == ("high-stiffness", "modular")
    by_angle = [[scores("start_area", "modular", angle, s) for s in KNOWN] for angle in angles]
    pooled = [np.concatenate(each) for each in by_angle]
    assert of.worst_p(1) == pytest.approx(dunn_by_hand(pooled).max(), rel=1e-10)
    assert of.kruskal.p[1] == pytest.approx(stats.kruskal(*pooled).pvalue, rel=1e-12)
    assert of.mean[1] == pytest.approx([each.mean() for each in pooled])
    assert of.falls(1)
    assert not replace(of, mean=of.mean[:, ::-1]).falls(1)
    logs = [np.mean([np.log(each).mean() for each in own]) for own in by_angle]
    over = of.over_first[1]
    assert np.isnan(over.estimate[0])
    assert over.estimate[1:] == pytest.approx(np.exp(np.array(logs[1:]) - logs[0]))
    assert (over.low[1:] < over.estimate[1:]).all()
    assert (over.high[1:] < 1).all()


def test_the_new_specimen_beside_its_neighbours(found, scores):
    new, steps = found.new, found.spread.steps
    assert (new.name, new.neighbours) == ("S_new", ("S1", "S3"))
    for design, of in ((3, ("modular", 0)), (6, ("constant-min", 0))):
        everyone = [scores("casr", *of, name) for name in ("S1", "S_new", "S3", "S5")]
        dunn = dunn_by_hand(everyone)  # pairs 01 02 03 12 13 23
        assert new.p_mean_rank[design].tolist() == pytest.approx([dunn[0], dunn[3]], rel=1e-10)
        assert new.discriminated[design] == (steps.low[3 * design : 3 * design + 2] > 1).all()
    assert new.between.all()


@pytest.mark.parametrize(("new", "neighbours"), [("S5", ("S3", "")), ("S1", ("", "S_new"))])
def test_a_new_specimen_at_the_end_has_one_neighbour_and_lies_between_nothing(
    new, neighbours, runs, stiffness_n_per_mm
):
    found = discriminate(runs, stiffness_n_per_mm, new, DiscriminationSettings())
    assert found.new.neighbours == neighbours
    there = [bool(name) for name in neighbours]
    assert np.isfinite(found.new.p_mean_rank).all(axis=0).tolist() == there
    assert not found.new.discriminated.any()


def mounted(rng, truth, mountings=3, presses=3, **scatter):
    scores = drawn(rng, np.asarray(truth), mountings=mountings, presses=presses, **scatter)
    return Mountings.of(scores, numbers(scores.shape[:2], mountings, presses), 0.043, np.ones(scores.shape))


def test_a_gap_is_the_contrast_over_mountings_in_sds_of_a_press():
    rng = np.random.default_rng(0)
    scores = drawn(rng, np.array([[0.0, 0.1], [0.1, 0.0]]), mountings=3, presses=4)
    found = gaps_of(Mountings.of(scores, numbers((2, 2), 3, 4), 0.043, np.ones(scores.shape)), (0, 1), 0.95)
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
        found = gaps_of(Mountings.of(scores, numbers((1, 2), 3, presses), 0.043, np.ones(scores.shape)), (0, 1), 0.95)
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


DESIGNS_MADE = [("high-stiffness", 0.0), ("high-stiffness", 30.0), ("modular", 0.0), ("modular", 30.0)]


def made(run_of, designs=DESIGNS_MADE, mountings=3):
    """Runs of the known specimens, their presses in mountings of their own."""
    runs = [run_of(name, angle, condition, presses=3 * mountings) for condition, angle in designs for name in KNOWN]
    return [replace(run, mounting=np.repeat(np.arange(1, mountings + 1), 3)) for run in runs]


def test_the_factors_count_mountings(run_of, stiffness_n_per_mm: dict[str, float]) -> None:
    """CASR rises with softness and falls with the angle, in both conditions alike: what the made runs hold."""
    factors = discriminate(made(run_of), stiffness_n_per_mm, "S_new").factors
    assert factors.not_positive == (0, 0)
    assert factors.constant == ()
    for found in (factors.casr, factors.area):
        assert found is not None
        assert found.error_df == 12 * 2
        at = {name: i for i, name in enumerate(found.effects)}
        assert found.p[at["specimen"]] < 1e-15
        assert found.p[at["angle"]] < 1e-10
        assert found.omega2[at["specimen"]] > 0.9
        assert found.omega2[at["condition × angle × specimen"]] < 0.3
        assert (found.low <= found.omega2).all()
        assert (found.omega2 <= found.high).all()


def test_where_all_was_mounted_once_nothing_tells_the_scatter_of_factors(runs, stiffness_n_per_mm) -> None:
    found = discriminate(runs, stiffness_n_per_mm, "S_new")
    assert (found.factors.casr, found.factors.area) == (None, None)
    assert any("mounted once" in note for note in found.notes)


def test_one_angle_is_no_factor(run_of: Callable[..., RunScores], stiffness_n_per_mm: dict[str, float]) -> None:
    runs = made(run_of, [("high-stiffness", 0.0), ("modular", 0.0)])
    factors = discriminate(runs, stiffness_n_per_mm, "S_new").factors
    assert factors.constant == ("angle",)
    assert factors.casr is not None
    assert factors.casr.effects == ("condition", "specimen", "condition × specimen")


def test_scores_without_a_logarithm_are_counted(
    run_of: Callable[..., RunScores], stiffness_n_per_mm: dict[str, float]
) -> None:
    runs = made(run_of, [("modular", 0.0)])
    casr = {name: values.copy() for name, values in runs[0].casr.items()}
    casr["front"][:3] = [-1e-3, 0.0, -1.0]
    runs[0] = dataclasses.replace(runs[0], casr=casr)
    factors = discriminate(runs, stiffness_n_per_mm, "S_new").factors
    assert factors.not_positive == (0, 3)
    assert factors.casr is not None
    assert factors.casr.error_df == 8 - 3
    assert factors.area is not None
    assert factors.area.error_df == 9 - 3


def test_runs_that_bear_no_model_have_none(
    run_of: Callable[..., RunScores], stiffness_n_per_mm: dict[str, float]
) -> None:
    runs = [run_of(s, 0.0, "modular", presses=1) for s in ("S1", "S3")]
    factors = discriminate(runs, stiffness_n_per_mm, "S_new").factors
    assert factors.casr is None
    assert factors.area is None
    assert np.all(np.array(factors.not_positive) == 0)
