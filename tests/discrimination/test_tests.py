"""Tests of areas and rates against SciPy and statsmodels, which share no code with ours."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from scipy import stats
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.weightstats import ttost_ind

from emg2vsa.discrimination import discriminate
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
