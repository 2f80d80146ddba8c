"""Welch, Games-Howell, Tukey, Levene and adjusted p beside scipy and statsmodels; what must not change the answer."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.oneway import anova_oneway

from emg2vsa.errors import SettingError
from emg2vsa.stats import studentized_range
from emg2vsa.stats.anova import one_way
from emg2vsa.stats.lsd import lsd
from emg2vsa.stats.multiplicity import Adjustment, adjust
from emg2vsa.stats.tukey import tukey
from emg2vsa.stats.variances import levene
from emg2vsa.stats.welch import games_howell, welch

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


@pytest.mark.parametrize(("center", "peer"), [("median", "median"), ("mean", "mean")])
def test_levene_is_scipys(center: str, peer: str) -> None:
    found = levene(DESIGNS, center).anova  # type: ignore[arg-type]
    for i, design in enumerate(DESIGNS):
        np.testing.assert_allclose([found.f[i], found.p[i]], stats.levene(*groups_of(design), center=peer), rtol=1e-10)


@pytest.mark.parametrize("equal_var", [True, False])
def test_tukey_and_games_howell_are_scipys(equal_var: bool) -> None:
    found = tukey(one_way(DESIGNS)) if equal_var else games_howell(DESIGNS)
    for i, design in enumerate(DESIGNS[:5]):
        peer = stats.tukey_hsd(*groups_of(design), equal_var=equal_var)
        interval = peer.confidence_interval(0.95)
        np.testing.assert_allclose(found.p[i], peer.pvalue[UPPER], atol=1e-12)
        np.testing.assert_allclose(found.low[i], interval.low[UPPER], rtol=1e-7)
        np.testing.assert_allclose(found.high[i], interval.high[UPPER], rtol=1e-7)


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


@pytest.mark.parametrize(
    ("method", "peer"),
    [("bonferroni", "bonferroni"), ("holm", "holm"), ("fdr_bh", "fdr_bh"), ("fdr_by", "fdr_by")],
)
def test_adjusted_p_is_statsmodels_and_ignores_absent_tests(method: Adjustment, peer: str) -> None:
    rng = np.random.default_rng(5)
    p = rng.uniform(0, 1, (20, 8)) ** 3
    p[rng.uniform(size=p.shape) < 0.2] = np.nan
    found = adjust(p, method)
    for row, adjusted in zip(p, found, strict=True):
        there = np.isfinite(row)
        np.testing.assert_allclose(adjusted[there], multipletests(row[there], method=peer)[1], rtol=1e-13)
        assert np.isnan(adjusted[~there]).all()


@given(st.lists(st.floats(0, 1), min_size=1, max_size=12), st.randoms(use_true_random=False))
@settings(max_examples=60, deadline=None)
def test_adjustments_keep_the_order_and_do_not_depend_on_it(p: list[float], random: object) -> None:
    values = np.array(p)
    order = np.array(random.sample(range(len(p)), len(p)))  # type: ignore[attr-defined]
    for method in ("bonferroni", "holm", "fdr_bh", "fdr_by"):
        found = adjust(values, method)  # type: ignore[arg-type]
        np.testing.assert_array_equal(adjust(values[order], method), found[order])  # type: ignore[arg-type]
        assert (np.diff(found[np.argsort(values)]) >= 0).all()
        assert (found >= values).all()
    np.testing.assert_array_equal(adjust(values, "bonferroni"), np.minimum(1, values * len(p)))
    assert (adjust(values, "holm") <= adjust(values, "bonferroni")).all()


def test_unknown_adjustment_is_named() -> None:
    with pytest.raises(SettingError, match="holm"):
        adjust([0.1], "sidak")  # type: ignore[arg-type]


@pytest.mark.parametrize("scale", [1e-300, 1.0, 1e300])
def test_scale_and_shift_do_not_matter(scale: float) -> None:
    values = DESIGNS * scale
    np.testing.assert_allclose(welch(values).p, welch(DESIGNS).p, rtol=1e-9)
    np.testing.assert_allclose(games_howell(values).p, games_howell(DESIGNS).p, rtol=1e-9)
    np.testing.assert_allclose(levene(values).anova.p, levene(DESIGNS).anova.p, rtol=1e-9)


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
    assert np.isnan(levene(hostile).anova.p).all()
    one_missing = np.array([[1.0, 2.0, 4.0], [nan, nan, nan], [6.0, 7.5, 9.0]])
    pair = games_howell(one_missing)
    np.testing.assert_array_equal(np.isnan(pair.p[0]), [True, False, True])
    assert pair.p[0, 1] == pytest.approx(
        stats.ttest_ind(one_missing[0], one_missing[2], equal_var=False).pvalue, rel=1e-9
    )
    assert pair.outcome(0, 1).method == "Games-Howell"
