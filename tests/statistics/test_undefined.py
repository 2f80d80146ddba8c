"""Designs at the edge: undefined with a reason, or refused. One table for what a test says where it has no answer."""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal

import numpy as np
import pytest

from emg2vsa.companions.groups import group_tests, pair_tests
from emg2vsa.companions.tidy import tidy_tests
from emg2vsa.errors import DataError
from emg2vsa.statistics.anova import brown_forsythe, one_way, welch
from emg2vsa.statistics.bayes import jzs_anova
from emg2vsa.statistics.equivalence import tost
from emg2vsa.statistics.kruskal import dunn, kruskal
from emg2vsa.statistics.lilliefors import lilliefors
from emg2vsa.statistics.mann_whitney import mann_whitney
from emg2vsa.statistics.mixed import balanced_mixed
from emg2vsa.statistics.normality import ks_normal, shapiro_wilk
from emg2vsa.statistics.outcome import Outcome
from emg2vsa.statistics.post_hoc import games_howell, lsd, tukey
from emg2vsa.statistics.repeated import friedman, paired_tests, rm_anova

nan = np.nan
PAIRS: dict[str, Callable[[np.ndarray], Outcome]] = {
    "lsd": lambda v: lsd(one_way(v)).outcome(),
    "tukey": lambda v: tukey(one_way(v)).outcome(),
    "games_howell": lambda v: games_howell(v).outcome(),
    "dunn": lambda v: dunn(kruskal(v)).outcome(),
    "mann_whitney": lambda v: mann_whitney(v).outcome(),
    "tost": lambda v: tost(v, 1.0).outcome(),
    "paired": lambda v: paired_tests(v.T).t.outcome(),
}
GROUPS: dict[str, Callable[[np.ndarray], Outcome]] = {
    "anova": lambda v: one_way(v).outcome(),
    "welch": lambda v: welch(v).outcome(),
    "kruskal": lambda v: kruskal(v).outcome(),
    "brown_forsythe": lambda v: brown_forsythe(v).outcome(),
    "repeated": lambda v: rm_anova(v.T).outcome(),
    "friedman": lambda v: friedman(v.T).outcome(),
    "icc": lambda v: rm_anova(v.T).consistency(),
}
SAMPLES: dict[str, Callable[[object], Outcome]] = {
    "ks": lambda v: ks_normal(v, standardise=True).outcome(),  # type: ignore[arg-type]
    "lilliefors": lambda v: lilliefors(v).outcome(),  # type: ignore[arg-type]
    "shapiro": lambda v: shapiro_wilk(v).outcome(),  # type: ignore[arg-type]
}
NO_SCATTER = {
    "one value a group": np.array([[1.0], [2.0], [3.0]]),
    "all values equal": np.ones((3, 4)),
    "no values": np.full((2, 3), nan),
}


@pytest.mark.parametrize("test", PAIRS)
def test_one_group_has_no_pairs(test: str) -> None:
    with pytest.raises(DataError, match="two groups"):
        PAIRS[test](np.array([[1.0, 2.0, 4.0]]))


@pytest.mark.parametrize("design", NO_SCATTER)
@pytest.mark.parametrize("test", sorted(PAIRS.keys() - {"mann_whitney", "dunn"}))
def test_pairs_without_scatter_say_so(test: str, design: str) -> None:
    outcome = PAIRS[test](NO_SCATTER[design])
    assert np.isnan([outcome.p, *(outcome.interval or ())]).all()
    assert any("undefined" in note for note in outcome.notes)


@pytest.mark.parametrize("test", GROUPS)
@pytest.mark.parametrize("values", [np.array([[1.0, 2.0, 4.0]]), np.full((2, 3), nan), np.ones((3, 4))])
def test_groups_that_cannot_be_compared_say_why(test: str, values: np.ndarray) -> None:
    outcome = GROUPS[test](values)
    assert np.isnan(outcome.p or 0.0)
    assert any("undefined" in note for note in outcome.notes)


@pytest.mark.parametrize("test", SAMPLES)
@pytest.mark.parametrize("row", [[0.1] * 10, [0.1], [nan, nan], [1e300] * 5, [nan, 1.0]])
def test_samples_without_spread_say_why(test: str, row: list[float]) -> None:
    outcome = SAMPLES[test](row)
    assert np.isnan([outcome.statistic, outcome.p]).all()
    assert outcome.notes[-1].startswith("undefined")


SAID: dict[str, tuple[Callable[[], Outcome], str]] = {
    "constant": (lambda: one_way([[0.1] * 3, [0.1] * 3]).outcome(), "undefined: all values are equal"),
    "one group": (lambda: one_way([[1.0, 2.0, 3.0]]).outcome(), "undefined: 1 group(s) with values"),
    "no group": (lambda: one_way([[nan], [nan]]).outcome(), "undefined: 0 group(s) with values"),
    "one value each": (lambda: one_way([[1.0], [2.0]]).outcome(), "undefined: one value a group leaves no variance"),
    "apart": (lambda: one_way([[0.1] * 3, [0.2] * 3]).outcome(), "the values within each group are equal: F is infin"),
    "distances, one group": (lambda: brown_forsythe([[1.0, 2.0, 4.0]]).outcome(), "undefined: 1 group(s) with values"),
    "distances of two": (lambda: brown_forsythe([[1.0, 2], [3, 5]]).outcome(), "undefined: no group has three values"),
    "distances alike": (
        lambda: brown_forsythe([[1.0, 3, 1, 3], [5, 7, 5, 7]]).outcome(),
        "undefined: every value is equally far from the median of its group",
    ),
    "distances, one value": (lambda: brown_forsythe([[1.0], [2.0]]).outcome(), "undefined: one value a group leaves"),
    "one variance": (lambda: welch([[1.0, 1, 1], [2, 2.5, 2]]).outcome(), "undefined: needs two groups of two or more"),
    "empty group": (lambda: mann_whitney([[1.0, 2.0], [nan, nan]]).outcome(), "undefined: a group has no values"),
    "many values": (lambda: mann_whitney(np.eye(2, 60)).outcome(), "more than 100 values: normal instead of exact"),
    "few ranks": (lambda: kruskal([[1.0, 2.0], [3.0, 4.0]]).outcome(), "p from chi squared, rough for groups of 2"),
    "alike in every person": (lambda: rm_anova([[1.0, 2], [2, 3]]).outcome(), "treatments differ by the same amounts"),
    "a gap": (lambda: rm_anova([[1.0, 2], [2, 5], [nan, 3]]).outcome(), "1 people with a gap left out"),
    "a gap in ranks": (lambda: friedman([[1.0, 2], [2, 5], [nan, 3]]).outcome(), "1 people with a gap left out"),
    "a gap in ratings": (lambda: rm_anova([[1.0, 2], [2, 5], [nan, 3]]).consistency(), "subjects with a gap, left out"),
    "disagreement": (lambda: rm_anova([[1.0, 2, 3], [3, 2, 1], [2, 2, 2]]).consistency(), "negative: subjects differ"),
    "no factor": (lambda: jzs_anova([[1.0], [2.0]]).outcome(), "Cauchy prior of scale r = 0.5"),
    "few values": (lambda: lilliefors([0.1, 0.2, 0.3]).outcome(), "undefined: 3 values, needs 4"),
    "steep": (lambda: lilliefors([0.0] * 19 + [1.0]).outcome(), "p below the simulated range, extrapolated"),
    "two values": (lambda: shapiro_wilk([0.1, 0.2]).outcome(), "undefined: 2 values, needs 3"),
    "repeats": (lambda: shapiro_wilk([1.0, 1.0, 2.0, 3.0]).outcome(), "values repeat: rounded data look less normal"),
    "long": (lambda: shapiro_wilk(np.arange(5001.0) ** 2).outcome(), "p extrapolated: fitted for up to 5000 values"),
    "estimated": (lambda: ks_normal([1.0, 2, 4], standardise=True).outcome(), "mean and SD estimated from the sample"),
    "raw": (lambda: ks_normal([1.0, 2, 4], standardise=False).outcome(), "against N(0, 1) in the unit of the data"),
    "margin": (lambda: tost([[1.0, 2, 4], [1, 2, 3]], 1.0).outcome(), "null hypothesis: the difference is 1 or more"),
    "no variance": (lambda: balanced_mixed(np.ones((3, 2, 2))).outcome(), "undefined: all values are equal"),
}


@pytest.mark.parametrize("case", SAID)
def test_the_first_note_is_the_reason(case: str) -> None:
    made, note = SAID[case]
    assert made().notes[0].startswith(note)


def test_later_notes() -> None:
    assert "power" in brown_forsythe(np.random.default_rng(1).standard_normal((3, 3))).outcome().notes[-1]
    assert "undefined" in jzs_anova([[1.0], [2.0]]).outcome().notes[1]
    assert "SD" in tost([[1.0, 2, 4], [1, 2, 3]], 1.0, "sd").outcome().notes[1]
    assert lilliefors(np.arange(10.0)).outcome().notes == shapiro_wilk([1.0, 1.5, 2.0, 3.0]).outcome().notes == ()


def test_no_design_at_all() -> None:
    empty = np.empty((0, 2, 1))
    assert one_way(empty).f.shape == (0,)
    assert lsd(one_way(empty)).p.shape == (0, 1)
    for test in (lilliefors, shapiro_wilk):
        assert test(np.empty((0, 5))).p.shape == (0,)
    assert np.isnan(shapiro_wilk(np.empty((2, 0))).statistic).all()
    assert ks_normal(np.empty((0, 4)), standardise=True).statistic.shape == (0,)


def test_an_empty_group_leaves_the_others_as_they_are() -> None:
    values = np.array([[1.0, 2.0, 3.0], [nan] * 3, [4.0, 5.0, 7.0]])
    found, other = (group_tests(v) for v in (values, values[[0, 2]]))
    assert found.anova.f == other.anova.f
    assert found.welch.p == other.welch.p
    pairs, pair = pair_tests(values, found), pair_tests(values[[0, 2]], other)
    for tests in ("lsd", "tukey", "games_howell"):
        assert getattr(pairs, tests).p[0, 1] == pytest.approx(getattr(pair, tests).p[0, 0], rel=1e-12)
        assert np.isnan(getattr(pairs, tests).difference[0, [0, 2]]).all()
        assert np.isnan(getattr(pairs, tests).p[0, [0, 2]]).all()
    assert np.isnan(pairs.dunn.p[0, [0, 2]]).all()
    assert np.isnan(pairs.mann_whitney.p[0, [0, 2]]).all()


def test_an_infinite_f_has_p_0_and_says_so() -> None:
    values = np.array([[1.0, 1.0, 1.0], [2.0, 2.0, 2.0], [2.0, 2.0, 2.0]])
    anova = group_tests(values).anova_outcome()
    assert (anova.statistic, anova.p, anova.estimate, anova.interval) == (np.inf, 0.0, 1.0, (1.0, 1.0))
    np.testing.assert_array_equal(lsd(one_way(values)).p[0], [0.0, 0.0, nan])
    repeated = rm_anova(values.T).outcome()
    assert (repeated.statistic, repeated.df, repeated.p) == (np.inf, (2.0, 4.0), 0.0)
    agreed = rm_anova([[1.0, 1.0], [2.0, 2.0], [3.0, 3.0]]).consistency()
    assert (agreed.estimate, agreed.interval) == (1.0, (1.0, 1.0))
    assert jzs_anova([[1.0, 1.0], [2.0, 2.0]]).bf01[0] == 0.0


@pytest.mark.parametrize("labels", [["1", "1.0", "2"], ["01", "1", "2"], ["1e1", "10", "2"]])
@pytest.mark.parametrize("column", ["group", "block"])
def test_one_number_written_in_two_ways_is_refused(labels: list[str], column: str) -> None:
    other, own = ["a", "b", "c"] * 4, [label for label in labels for _ in range(4)]
    group, block = (own, other) if column == "group" else (other, own)
    with pytest.raises(DataError, match=f"names of {column}s"):
        tidy_tests(np.arange(12).astype(object).tolist(), group, block, 0.05)


def test_names_that_only_look_like_numbers_are_let_be() -> None:
    tidy_tests(list(range(8)), ["nan", "inf", "S1", "S01"] * 2, None, 0.05)  # type: ignore[arg-type]


NO_DESIGN: dict[str, Callable[[], object]] = {
    "ragged": lambda: one_way([[1, 2], [3]]),
    "one row": lambda: one_way([1, 2, 3]),
    "texts": lambda: one_way([["a", "b"], ["c", "d"]]),
    "empty": lambda: one_way([[], []]),
    "no number": lambda: one_way([[Decimal(1), "x"]]),
    "complex": lambda: one_way(np.ones((3, 4)) * 1j),
    "bayes": lambda: jzs_anova([1.0, 2.0]),
    "tost": lambda: tost([1.0, 2.0], 1.0),
    "repeated": lambda: rm_anova([1.0, 2.0]),
}


@pytest.mark.parametrize("case", NO_DESIGN)
def test_what_is_not_a_design_is_refused(case: str) -> None:
    with pytest.raises(DataError, match="analysis of variance"):
        NO_DESIGN[case]()


@pytest.mark.parametrize("values", [np.ones((1, 3, 2)), np.ones((4, 3, 1)), np.full((4, 3, 2), nan), np.ones(4)])
def test_gaps_and_missing_replicates_are_named(values: np.ndarray) -> None:
    with pytest.raises(DataError, match="balanced mixed model"):
        balanced_mixed(values)


def test_an_outcome_holds_no_numpy() -> None:
    values = np.random.default_rng(0).standard_normal((3, 4))
    for outcome in (*(test(values) for test in (PAIRS | GROUPS).values()), SAMPLES["ks"](values)):
        assert not any(isinstance(value, np.generic | np.ndarray) for value in vars(outcome).values())
