"""Effect sizes: definitions, intervals that give back the tail they were asked for, the noncentral laws far from 0."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import special, stats

from emg2vsa.statistics.anova import one_way
from emg2vsa.statistics.effect_size import hedges_g, noncentral_f, noncentral_t, omega2, share_interval


def test_omega2_from_the_sums_of_squares() -> None:
    anova = one_way(np.random.default_rng(1).standard_normal((4, 9)) + np.arange(4)[:, None] * 0.7)
    f, df1, df2 = anova.f[0], 3, 32
    within = anova.sd[0] ** 2 * df2
    between = f * df1 * anova.sd[0] ** 2
    total, ms = between + within, anova.sd[0] ** 2
    assert omega2(f, df1, df1 + df2 + 1) == pytest.approx((between - df1 * ms) / (total + ms), rel=1e-12)


@given(st.floats(0.01, 200), st.integers(1, 20), st.integers(2, 200), st.floats(0.5, 0.99))
@settings(max_examples=60, deadline=None)
def test_ends_of_the_share_interval_leave_the_tails(f: float, df1: int, df2: int, confidence: float) -> None:
    low, high = share_interval(f, df1, df2, df1 + df2 + 1, confidence)
    tail, total = (1 - confidence) / 2, df1 + df2 + 1
    for share, probability in ((low, 1 - tail), (high, tail)):
        if share > 1e-9:
            found = stats.ncf.cdf(f, df1, df2, share * total / (1 - share))
            assert found == pytest.approx(probability, abs=1e-8)
        else:
            assert stats.f.cdf(f, df1, df2) <= probability + 1e-8


def test_the_notes_example() -> None:
    low, high = share_interval(5.23, 4, 45, 50)
    assert (round(float(low), 2), round(float(high), 2)) == (0.06, 0.46)


@given(st.floats(-20, 20), st.integers(2, 40), st.integers(2, 40))
@settings(max_examples=60, deadline=None)
def test_ends_of_the_g_interval_leave_the_tails(t: float, n1: int, n2: int) -> None:
    g, low, high = hedges_g(t, n1, n2)
    df, unit = n1 + n2 - 2, float(hedges_g(1.0, n1, n2)[0])
    assert g == pytest.approx(t * unit, abs=1e-12)
    assert low <= g <= high
    assert stats.nct.cdf(t, df, low / unit) == pytest.approx(0.975, abs=1e-7)
    assert stats.nct.cdf(t, df, high / unit) == pytest.approx(0.025, abs=1e-7)


def test_g_corrects_d() -> None:
    g, _, _ = hedges_g(2.0, 10, 10)
    assert float(g) == pytest.approx(2.0 * np.sqrt(0.2) * (1 - 3 / (4 * 18 - 1)), rel=1e-3)


def test_undefined_and_infinite() -> None:
    np.testing.assert_array_equal(share_interval([np.nan, np.inf], 3, 20, 24)[1], [np.nan, 1.0])
    np.testing.assert_array_equal(omega2([np.nan, np.inf], 3, 24), [np.nan, 1.0])
    assert np.isnan(hedges_g(np.nan, 5, 5)[1])


@given(st.floats(0, 12), st.integers(1, 60), st.integers(1, 600))
@settings(max_examples=60, deadline=None)
def test_omega2_lies_in_its_interval(f: float, df1: int, df2: int) -> None:
    """The sample's eta squared need not: at F = 0.92 with 199 and 3800 df it is .046, the interval [0, .01]."""
    low, high = share_interval(f, df1, df2, df1 + df2 + 1)
    assert low <= omega2(f, df1, df1 + df2 + 1) <= high + 1e-15


def columns(*values: float) -> list[np.ndarray]:
    return [np.array([value], dtype=float) for value in values]


def true_t(df: float, nc: float, t: float) -> float:
    """The normal numerator integrated out."""
    with mpmath.workdps(30):

        def at(z: mpmath.mpf) -> mpmath.mpf:
            above = mpmath.gammainc(mpmath.mpf(df) / 2, df * ((z + nc) / t) ** 2 / 2, mpmath.inf, regularized=True)
            return mpmath.npdf(z) * above

        return float(mpmath.quad(at, [-12, -6, -3, 0, 3, 6, 12]))


@pytest.mark.parametrize(
    ("df", "nc", "t"),
    [(1, 1001, 1001), (18, 1001, 700), (18, 1001, 1100), (200, 1001, 1040), (3, 5e3, 9e3), (18, 1e8, 9e7)],
)  # fmt: skip
def test_t_far_from_0(df: float, nc: float, t: float) -> None:
    assert noncentral_t(*columns(df, nc, t))[0] == pytest.approx(true_t(df, nc, t), rel=1e-11)


@pytest.mark.parametrize(
    ("df1", "df2", "nc", "f"), [(2, 27, 1.1e7, 5e6), (9, 400, 1.1e7, 1.2e6), (1, 4, 2e7, 1e7), (5, 60, 4e7, 9e6)]
)
def test_f_where_scipys_series_still_ends(df1: float, df2: float, nc: float, f: float) -> None:
    assert noncentral_f(*columns(df1, df2, nc, f))[0] == pytest.approx(special.ncfdtr(df1, df2, nc, f), abs=1e-9)


def test_the_two_ways_meet() -> None:
    series, mean = (noncentral_t(*columns(18, nc, 1050.0))[0] for nc in (1000.0, 1000.0 + 1e-9))
    assert series == pytest.approx(mean, abs=1e-11)


@pytest.mark.parametrize("t", [1e5, 1e6, 1e9, 1e15])
def test_an_interval_of_g_holds_g_when_nothing_but_rounding_scatters(t: float) -> None:
    """Its ends are in proportion to t: there they are those of the spread of the denominator."""
    g, low, high = (float(value) / t for value in hedges_g(t, 10, 10))
    assert low < g < high
    ends = [g * np.sqrt(special.chdtri(18, p) / 18) for p in (0.975, 0.025)]
    assert [low, high] == pytest.approx(ends, rel=1e-8)
    assert [-float(value) / t for value in hedges_g(-t, 10, 10)] == pytest.approx([g, high, low])


@pytest.mark.parametrize("f", [1e7, 1e10, 1e13])
def test_an_interval_of_eta2_is_in_proportion_to_f_when_nothing_but_rounding_scatters(f: float) -> None:
    low, high = (float(share) for share in share_interval(f, 2, 27, 30))
    noncentrality = [2 * f * special.chdtri(27, p) / 27 for p in (0.975, 0.025)]
    assert [1 / (1 - low), 1 / (1 - high)] == pytest.approx([1 + nc / 30 for nc in noncentrality], rel=3e-3)
