"""Designs at the edge: right to the digits, or refused with a reason. Truth: rational numbers and 30 digits."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from itertools import combinations

import mpmath
import numpy as np
import pytest
from scipy import stats

from emg2vsa.companions.groups import group_tests, normality_of
from emg2vsa.companions.pairs import pair_tests
from emg2vsa.companions.tidy import tidy_tests
from emg2vsa.errors import DataError
from emg2vsa.statistics.agreement import icc
from emg2vsa.statistics.anova import brown_forsythe, one_way
from emg2vsa.statistics.equivalence import tost
from emg2vsa.statistics.factorial import factorial
from emg2vsa.statistics.friedman import friedman
from emg2vsa.statistics.kruskal import dunn, kruskal
from emg2vsa.statistics.mann_whitney import mann_whitney
from emg2vsa.statistics.mixed import balanced_mixed
from emg2vsa.statistics.outcome import Outcome
from emg2vsa.statistics.paired import paired_tests
from emg2vsa.statistics.post_hoc import lsd, tukey
from emg2vsa.statistics.repeated import rm_anova
from emg2vsa.statistics.trend import trend
from emg2vsa.statistics.unbalanced_mixed import UnbalancedMixed, unbalanced_mixed
from emg2vsa.statistics.welch import games_howell, welch

nan = np.nan
PAIRS: dict[str, Callable[[np.ndarray], Outcome]] = {
    "lsd": lambda v: lsd(one_way(v)).outcome(),
    "tukey": lambda v: tukey(one_way(v)).outcome(),
    "games_howell": lambda v: games_howell(v).outcome(),
    "dunn": lambda v: dunn(kruskal(v)).outcome(),
    "mann_whitney": lambda v: mann_whitney(v).outcome(),
    "tost": lambda v: tost(v, 1.0).outcome(),
    "tost paired": lambda v: tost(v, 1.0, "paired").outcome(),
    "paired": lambda v: paired_tests(v.T).t.outcome(),
}
GROUPS: dict[str, Callable[[np.ndarray], Outcome]] = {
    "anova": lambda v: one_way(v).outcome(),
    "welch": lambda v: welch(v).outcome(),
    "kruskal": lambda v: kruskal(v).outcome(),
    "brown_forsythe": lambda v: brown_forsythe(v).outcome(),
    "repeated": lambda v: rm_anova(v.T).outcome(),
    "friedman": lambda v: friedman(v.T).outcome(),
    "icc": lambda v: icc(v.T).outcome(),
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
    assert outcome.p is not None
    assert np.isnan(outcome.p)
    assert outcome.interval is not None
    assert np.isnan(outcome.interval).all()
    assert any("undefined" in note for note in outcome.notes)


@pytest.mark.parametrize("test", GROUPS)
@pytest.mark.parametrize("values", [np.array([[1.0, 2.0, 4.0]]), np.full((2, 3), nan), np.ones((3, 4))])
def test_groups_that_cannot_be_compared_say_why(test: str, values: np.ndarray) -> None:
    outcome = GROUPS[test](values)
    assert outcome.p is not None
    assert np.isnan(outcome.p)
    assert any("undefined" in note for note in outcome.notes)


def test_reasons_are_the_true_ones() -> None:
    assert "1 group(s)" in brown_forsythe([[1.0, 2.0, 4.0]]).outcome().notes[0]
    assert "no group has three values" in brown_forsythe([[1.0, 2.0], [3.0, 5.0]]).outcome().notes[0]
    assert "all values are equal" in one_way(np.ones((2, 3))).outcome().notes[0]
    assert "a group has no values" in mann_whitney([[1.0, 2.0], [nan, nan]]).outcome().notes[0]


def test_an_empty_group_leaves_the_others_as_they_are() -> None:
    values = np.array([[1.0, 2.0, 3.0], [nan] * 3, [4.0, 5.0, 7.0]])
    found, other = (group_tests(v) for v in (values, values[[0, 2]]))
    assert found.anova.f == other.anova.f
    assert found.welch.p == other.welch.p
    pairs, pair = pair_tests(values, found), pair_tests(values[[0, 2]], other)
    for tests in ("lsd", "tukey", "games_howell"):
        assert getattr(pairs, tests).p[0, 1] == pytest.approx(getattr(pair, tests).p[0, 0], rel=1e-12)
        assert np.isnan(getattr(pairs, tests).difference[0, [0, 2]]).all()


def test_groups_of_two_in_rational_numbers() -> None:
    values = [[1, 4], [2, 3], [10, 12]]
    found = group_tests(np.array(values, dtype=float))
    exact = [[Fraction(v) for v in group] for group in values]
    means, grand = [sum(g) / 2 for g in exact], Fraction(sum(map(sum, values)), 6)
    between = 2 * sum((m - grand) ** 2 for m in means)
    within = sum((v - m) ** 2 for g, m in zip(exact, means, strict=True) for v in g)
    assert found.anova.f[0] == pytest.approx(float(between / 2 / (within / 3)), rel=1e-14)
    with mpmath.workdps(30):
        x = mpmath.mpf(3) / (3 + 2 * mpmath.mpf(between / 2 / (within / 3)).real)
        assert found.anova.p[0] == pytest.approx(float(mpmath.betainc(1.5, 1, 0, x, regularized=True)), rel=1e-13)
    pair = lsd(found.anova)
    t = (means[0] - means[1]) / mpmath.sqrt(mpmath.mpf(within.numerator) / within.denominator / 3)
    assert pair.statistic[0, 0] == pytest.approx(float(t), abs=1e-15)


def test_an_infinite_f_has_p_0_and_says_so() -> None:
    values = np.array([[1.0, 1.0, 1.0], [2.0, 2.0, 2.0], [2.0, 2.0, 2.0]])
    anova = group_tests(values).anova_outcome()
    assert (anova.statistic, anova.p, anova.estimate, anova.interval) == (np.inf, 0.0, 1.0, (1.0, 1.0))
    assert "infinite" in anova.notes[0]
    assert (lsd(one_way(values)).p[0] == [0.0, 0.0, nan])[:2].all()
    repeated = rm_anova(values.T).outcome()
    assert (repeated.statistic, repeated.df, repeated.p) == (np.inf, (2.0, 4.0), 0.0)
    assert "infinite" in repeated.notes[0]


def test_omega2_stands_inside_its_interval_where_eta2_does_not() -> None:
    values = np.random.default_rng(3).standard_normal((200, 20))
    outcome = group_tests(values).anova_outcome()
    assert outcome.interval is not None
    assert outcome.estimate is not None
    assert outcome.effect_size is not None
    assert outcome.interval[0] <= outcome.estimate <= outcome.interval[1] < outcome.effect_size


MASKED: dict[str, Callable[[np.ndarray], object]] = {
    **{name: (lambda v, test=test: test(v).p) for name, test in {**GROUPS, **PAIRS}.items()},
    "normality": lambda v: [outcome.p for outcome in normality_of(v).outcomes(0)],
    "factorial": lambda v: factorial(v, {"a": np.repeat([0, 1, 2], 6)}).p[0],
    "trend": lambda v: trend(np.repeat(["a", "b", "c"], 6), np.full(18, "x"), np.tile(np.arange(6.0), 3), v.ravel()).p,
    "unbalanced": lambda v: _p(unbalanced_mixed(v.reshape(3, 2, 3))),
}


def _p(found: UnbalancedMixed | Outcome) -> float | None:
    return found.p


@pytest.mark.parametrize("test", MASKED)
def test_masked_values_are_no_values(test: str) -> None:
    values = np.random.default_rng(2).standard_normal((3, 6))
    masked = np.ma.masked_array(values.copy(), mask=np.zeros((3, 6), dtype=bool))
    masked[0, 1] = 1e6
    masked[0, 1] = np.ma.masked
    masked[2, 4] = np.ma.masked
    values[0, 1] = values[2, 4] = nan
    np.testing.assert_array_equal(MASKED[test](masked), MASKED[test](values))


@pytest.mark.parametrize("labels", [["1", "1.0", "2"], ["01", "1", "2"], ["1e1", "10", "2"]])
@pytest.mark.parametrize("column", ["group", "block"])
def test_one_number_written_in_two_ways_is_refused(labels: list[str], column: str) -> None:
    other = ["a", "b", "c"] * 4
    own = [label for label in labels for _ in range(4)]
    values = np.arange(12).astype(object)
    group, block = (own, other) if column == "group" else (other, own)
    with pytest.raises(DataError, match=f"names of {column}s"):
        tidy_tests(values.tolist(), group, block, 0.05)


def test_names_that_only_look_like_numbers_are_let_be() -> None:
    tidy_tests(list(range(8)), ["nan", "inf", "S1", "S01"] * 2, None, 0.05)  # type: ignore[arg-type]


@pytest.mark.parametrize("power", [20, 30, 40])
def test_pairs_keep_their_digits_at_a_large_offset(power: int) -> None:
    """Values are multiples of 2**-10, so that the offset adds no rounding of its own, and t is exact in rationals."""
    rng = np.random.default_rng(power)
    values = np.round(rng.standard_normal((3, 7)) * 2**10) / 2**10
    far = values + 2.0**power
    exact = [[Fraction(float(v)) for v in group] for group in values]
    means = [sum(g) / 7 for g in exact]
    squares = [sum((v - m) ** 2 for v in g) for g, m in zip(exact, means, strict=True)]
    pairs = pair_tests(far, group_tests(far))
    paired = paired_tests(far.T)
    for i, (a, b) in enumerate(combinations(range(3), 2)):
        difference = means[a] - means[b]
        pooled = _root(sum(squares) / 18 * Fraction(2, 7))
        own = _root((squares[a] + squares[b]) / 12 * Fraction(2, 7))
        welch_se = _root((squares[a] + squares[b]) / 42)
        between = [x - y for x, y in zip(exact[a], exact[b], strict=True)]
        paired_se = _root(sum((d - difference) ** 2 for d in between) / 42)
        assert pairs.lsd.statistic[0, i] == pytest.approx(float(difference) / pooled, rel=1e-12)
        assert pairs.tukey.statistic[0, i] == pytest.approx(abs(float(difference)) / pooled * np.sqrt(2), rel=1e-12)
        assert pairs.games_howell.statistic[0, i] == pytest.approx(
            abs(float(difference)) / welch_se * np.sqrt(2), rel=1e-12
        )
        correction = float(mpmath.gamma(6) / mpmath.gamma(5.5) / mpmath.sqrt(6))
        assert pairs.g[0, i] == pytest.approx(float(difference) / own * np.sqrt(2 / 7) * correction, rel=1e-12)
        assert paired.t.statistic[0, i] == pytest.approx(float(difference) / paired_se, rel=1e-12)
        assert tost(far, 1.0).of.difference[0, i] == pytest.approx(float(difference), rel=1e-12)
        shift = np.median(np.subtract.outer(values[a], values[b]))
        assert pairs.mann_whitney.shift[0, i] == pytest.approx(shift, rel=1e-12)


def _root(value: Fraction) -> float:
    with mpmath.workdps(30):
        return float(mpmath.sqrt(mpmath.mpf(value.numerator) / value.denominator))


def test_models_over_people_keep_their_digits_at_a_large_offset() -> None:
    y = np.round(np.random.default_rng(0).standard_normal((6, 3, 4)) * 2**10) / 2**10
    far = y + 2.0**30
    assert balanced_mixed(far).f == pytest.approx(balanced_mixed(y).f, rel=1e-12)
    assert rm_anova(far.mean(axis=2)).f == pytest.approx(rm_anova(y.mean(axis=2)).f, rel=1e-12)
    y[0, 0, 0] = nan
    near, other = unbalanced_mixed(y), unbalanced_mixed(y + 2.0**30)
    assert isinstance(near, UnbalancedMixed)
    assert isinstance(other, UnbalancedMixed)
    assert other.f == pytest.approx(near.f, rel=1e-12)
    assert other.pairs.p == pytest.approx(near.pairs.p, rel=1e-11)


def test_sd_of_one_constant_group_beside_another() -> None:
    """No Welch test without a variance; the pooled test is Student's."""
    values = np.array([[1.0, 1.0, 1.0], [2.0, 2.5, 2.0]])
    assert "not all equal" in welch(values).outcome().notes[0]
    peer = stats.ttest_ind_from_stats(1, 0, 3, 13 / 6, np.std(values[1], ddof=1), 3)
    assert lsd(one_way(values)).p[0, 0] == pytest.approx(peer.pvalue, rel=1e-12)
