"""Welch, Games-Howell, Tukey, Levene and adjusted p beside scipy and statsmodels; what must not change the answer."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.oneway import anova_oneway

from emg2vsa.companions.groups import group_tests
from emg2vsa.companions.pairs import pair_tests
from emg2vsa.errors import DataError
from emg2vsa.statistics import studentized_range
from emg2vsa.statistics.anova import brown_forsythe, one_way
from emg2vsa.statistics.multiplicity import Adjustment, adjust
from emg2vsa.statistics.post_hoc import lsd, tukey
from emg2vsa.statistics.welch import games_howell, welch

UPPER = np.triu_indices(4, 1)


def unequal(seed: int, k: int = 4, n: int = 9) -> np.ndarray:
    rng = np.random.default_rng(seed)
    values = rng.standard_normal((k, n)) * np.geomspace(1, 4, k)[:, None] + 0.8 * np.arange(k)[:, None]
    values[np.arange(n) >= rng.integers(3, n + 1, (k, 1))] = np.nan
    return values


def groups_of(design: np.ndarray) -> list[np.ndarray]:
    return [group[np.isfinite(group)] for group in design]


DESIGNS = np.array([unequal(seed) for seed in range(12)])


def test_welch_is_statsmodels() -> None:
    found = welch(DESIGNS)
    for i, design in enumerate(DESIGNS):
        peer = anova_oneway(groups_of(design), use_var="unequal")
        np.testing.assert_allclose(
            [found.f[i], found.df2[i], found.p[i]], [peer.statistic, peer.df[1], peer.pvalue], 1e-11
        )


def test_brown_forsythe_is_scipys() -> None:
    found = brown_forsythe(DESIGNS).anova
    for i, design in enumerate(DESIGNS):
        np.testing.assert_allclose([found.f[i], found.p[i]], stats.levene(*groups_of(design)), rtol=1e-10)


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


@pytest.mark.parametrize("scale", [1e-300, 1.0, 1e300])
def test_scale_and_shift_do_not_matter(scale: float) -> None:
    values = DESIGNS * scale
    np.testing.assert_allclose(welch(values).p, welch(DESIGNS).p, rtol=1e-9)
    np.testing.assert_allclose(games_howell(values).p, games_howell(DESIGNS).p, rtol=1e-9)
    np.testing.assert_allclose(brown_forsythe(values).anova.p, brown_forsythe(DESIGNS).anova.p, rtol=1e-9)


def test_hostile_designs_are_undefined_and_say_so() -> None:
    nan = np.nan
    hostile = np.array(
        [
            [[1.0, 2.0, 4.0], [nan, nan, nan], [nan, nan, nan]],
            [[3.0, 3.0, 3.0], [3.0, 3.0, 3.0], [3.0, 3.0, 3.0]],
            [[1.0, nan, nan], [2.0, nan, nan], [5.0, nan, nan]],
        ]
    )
    found = welch(hostile)
    assert np.isnan(found.f).all()
    assert all("undefined" in found.outcome(i).notes[0] for i in range(3))
    assert np.isnan(games_howell(hostile).p).all()
    assert np.isnan(tukey(one_way(hostile)).p).all()
    assert np.isnan(brown_forsythe(hostile).anova.p).all()
    one_missing = np.array([[1.0, 2.0, 4.0], [nan, nan, nan], [6.0, 7.5, 9.0]])
    pair = games_howell(one_missing)
    np.testing.assert_array_equal(np.isnan(pair.p[0]), [True, False, True])
    assert pair.p[0, 1] == pytest.approx(
        stats.ttest_ind(one_missing[0], one_missing[2], equal_var=False).pvalue, rel=1e-9
    )
    assert pair.outcome(0, 1).method == "Games-Howell"


@pytest.mark.parametrize("offset", [2.0**30, 2.0**42])
def test_an_origin_far_away_costs_pairs_no_digit(offset: float) -> None:
    """Sixteenths keep all their bits beside 2^42, so that the answers must not move."""
    values = np.round(np.random.default_rng(0).standard_normal((3, 10)) * 16) / 16
    near, far = (one_way(values + shift) for shift in (0.0, offset))
    for test in (lsd, tukey):
        np.testing.assert_allclose(test(far).p, test(near).p, rtol=1e-12)
        np.testing.assert_allclose(test(far).low, test(near).low, rtol=1e-12)
    tests = [pair_tests(values + shift, group_tests(values + shift)) for shift in (0.0, offset)]
    np.testing.assert_allclose(tests[1].g, tests[0].g, rtol=1e-12)
    np.testing.assert_allclose(tests[1].games_howell.low, tests[0].games_howell.low, rtol=1e-12)


def test_masked_values_are_not_there() -> None:
    values = np.random.default_rng(4).standard_normal((3, 8))
    gap = np.where(np.arange(8) == 2, np.nan, values)
    masked = np.ma.masked_array(np.where(np.isnan(gap), 1e6, gap), np.isnan(gap))
    assert one_way(masked).f[0] == one_way(gap).f[0]
    assert lsd(one_way(masked)).p.tolist() == lsd(one_way(gap)).p.tolist()


def test_complex_numbers_are_refused() -> None:
    with pytest.raises(DataError, match="complex"):
        one_way(np.ones((3, 4)) * 1j)
