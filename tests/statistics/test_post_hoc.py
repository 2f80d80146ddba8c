"""Pairs of groups and adjusted p beside scipy, statsmodels and rational numbers."""

from __future__ import annotations

from fractions import Fraction
from itertools import combinations

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from statsmodels.stats.multitest import multipletests

from emg2vsa.companions.groups import group_tests, pair_tests
from emg2vsa.statistics import studentized_range
from emg2vsa.statistics.anova import one_way
from emg2vsa.statistics.equivalence import tost
from emg2vsa.statistics.multiplicity import Adjustment, adjust
from emg2vsa.statistics.post_hoc import games_howell, lsd, tukey
from emg2vsa.statistics.repeated import paired_tests
from tests.statistics.unequal_groups import DESIGNS, groups_of, unequal

UPPER = np.triu_indices(4, 1)


SCIPY = {
    "tukey": [
        [[0.8904282412682, 0.05446974356019, 0.2853820070466, 0.006188710374097, 0.05038291318722, 0.6982008946122],
         [-2.095000093161, -5.284253106374, -4.329473861415, -5.87611674868, -4.918064330968, -1.371300012793],
         [3.559092851411, 0.03889939859005, 0.8786941894638, -0.8333297173546, 0.003191900766672, 3.165874048627]],
        [[0.9887219349218, 0.9937450614187, 0.3031535016584, 0.9997674496704, 0.5261834788211, 0.4012878912032],
         [-4.508826942459, -3.980422920133, -6.669000547065, -3.822679722075, -6.482471431846, -6.228893949982],
         [3.577451854107, 3.295088455081, 1.417278249501, 4.068720345376, 2.162124222635, 1.662506117469]],
        [[0.9659639517206, 0.5657485253938, 0.8334231840447, 0.8643899616733, 0.9855420921319, 0.9710468974607],
         [-5.095834998153, -5.982894832868, -5.470026305738, -5.42421226205, -4.90596369467, -3.410678211883],
         [3.625560053711, 2.130274570924, 2.909219023821, 3.041866944548, 3.815431357195, 4.70249119191]],
    ],
    "games_howell": [
        [[0.6256216946666, 0.01160242797671, 0.1762343596022, 0.006852910605307, 0.08084872477506, 0.7792612657933],
         [-1.293909808357, -4.59931612003, -4.09621291919, -5.776420386317, -5.167194194996, -1.833555822384],
         [2.758002566608, -0.6460375877538, 0.645433247239, -0.9330260797172, 0.252321764795, 3.628129858218]],
        [[0.672894052712, 0.9886689563003, 0.5258204500845, 0.9994715965642, 0.6600832172492, 0.7029418374059],
         [-1.695798537046, -3.762449033367, -9.228311720251, -3.309031680235, -8.752012291798, -8.891821678816],
         [0.7644234486932, 3.077114568315, 3.976589422687, 3.555072303536, 4.431665082586, 4.325433846304]],
        [[0.7006352314121, 0.1280620806257, 0.9146516824212, 0.429574396354, 0.9919291279144, 0.9877899799543],
         [-2.760424648527, -4.292581258904, -7.91093032077, -3.450498544693, -7.179359738814, -5.986053192463],
         [1.290149704085, 0.4399609969604, 5.350123038852, 1.068153227191, 6.088827401338, 7.27786617249]],
    ],
}  # fmt: skip
"""p, low and high of all pairs of the first three designs by SciPy 1.17, which takes 80 s for them:

    peer = stats.tukey_hsd(*groups_of(design), equal_var=True)  # False: Games and Howell
    interval = peer.confidence_interval(0.95)
    [[float(f"{v:.13g}") for v in table[UPPER]] for table in (peer.pvalue, interval.low, interval.high)]
"""


@pytest.mark.parametrize("name", SCIPY)
def test_tukey_and_games_howell_are_scipys(name: str) -> None:
    found = tukey(one_way(DESIGNS)) if name == "tukey" else games_howell(DESIGNS)
    for i, (p, low, high) in enumerate(SCIPY[name]):
        np.testing.assert_allclose(found.p[i], p, atol=1e-12)
        np.testing.assert_allclose(found.low[i], low, rtol=1e-7)
        np.testing.assert_allclose(found.high[i], high, rtol=1e-7)


def test_two_groups_are_the_t_test() -> None:
    values = DESIGNS[:, :2]
    anova, own = one_way(values), games_howell(values)
    np.testing.assert_allclose(tukey(anova).p, lsd(anova).p, rtol=1e-10)
    for i, design in enumerate(values):
        assert own.p[i, 0] == pytest.approx(stats.ttest_ind(*groups_of(design), equal_var=False).pvalue, rel=1e-10)


@pytest.mark.parametrize(("k", "df"), [(2, 5), (3, 27), (5, 45), (5, 3.7), (10, 2), (14, 126), (3, 1)])
def test_studentized_range_is_scipys(k: int, df: float) -> None:
    q = np.array([0.5, 2.0, 3.5, 6.0, 12.0])
    np.testing.assert_allclose(
        studentized_range.survival(q, k, df), stats.studentized_range.sf(q, k, df), rtol=3e-10, atol=3e-12
    )


def test_range_of_two_keeps_the_digits_of_small_p() -> None:
    t = np.array([1.0, 5.0, 10.0, 20.0])
    found = studentized_range.survival(t * np.sqrt(2), 2, 45)
    np.testing.assert_allclose(found[:3], 2 * stats.t.sf(t[:3], 45), rtol=1e-9)


@given(st.integers(2, 12), st.floats(1, 300), st.floats(0.5, 0.999))
@settings(max_examples=15, deadline=None)
def test_quantile_is_the_inverse(k: int, df: float, probability: float) -> None:
    q = studentized_range.quantile(probability, k, df)
    assert studentized_range.survival(q, k, df) == pytest.approx(1 - probability, abs=1e-11)


def test_protected_lsd_needs_a_significant_f() -> None:
    anova = one_way(np.array([unequal(3), unequal(3) + np.arange(4)[:, None] * 9.0]) * [[[1.0]], [[1.0]]])
    open_, closed = lsd(anova), lsd(anova, protected=True)
    for i in range(2):
        expected = open_.p[i] if anova.p[i] < 0.05 else np.ones(6)
        np.testing.assert_array_equal(closed.p[i], expected)
    assert anova.p[1] < 0.05


@pytest.mark.parametrize("method", ["bonferroni", "holm", "fdr_bh"])
def test_adjusted_p_is_statsmodels_and_ignores_absent_tests(method: Adjustment) -> None:
    rng = np.random.default_rng(5)
    p = rng.uniform(0, 1, (20, 8)) ** 3
    p[rng.uniform(size=p.shape) < 0.2] = np.nan
    found = adjust(p, method)
    for row, adjusted in zip(p, found, strict=True):
        there = np.isfinite(row)
        np.testing.assert_allclose(adjusted[there], multipletests(row[there], method=method)[1], rtol=1e-13)
        assert np.isnan(adjusted[~there]).all()


@given(st.lists(st.floats(0, 1), min_size=1, max_size=12), st.randoms(use_true_random=False))
@settings(max_examples=60, deadline=None)
def test_adjustments_keep_the_order_and_do_not_depend_on_it(p: list[float], random: object) -> None:
    values = np.array(p)
    order = np.array(random.sample(range(len(p)), len(p)))  # type: ignore[attr-defined]
    for method in ("bonferroni", "holm", "fdr_bh"):
        found = adjust(values, method)  # type: ignore[arg-type]
        np.testing.assert_array_equal(adjust(values[order], method), found[order])  # type: ignore[arg-type]
        assert (np.diff(found[np.argsort(values)]) >= 0).all()
        assert (found >= values).all()
    np.testing.assert_array_equal(adjust(values, "bonferroni"), np.minimum(1, values * len(p)))
    assert (adjust(values, "holm") <= adjust(values, "bonferroni")).all()


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
        assert tost(far, 1.0).difference[0, i] == pytest.approx(float(difference), rel=1e-12)
        shift = np.median(np.subtract.outer(values[a], values[b]))
        assert pairs.mann_whitney.shift[0, i] == pytest.approx(shift, rel=1e-12)


def _root(value: Fraction) -> float:
    with mpmath.workdps(30):
        return float(mpmath.sqrt(mpmath.mpf(value.numerator) / value.denominator))
