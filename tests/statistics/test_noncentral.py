"""The noncentral t and F far from 0, against arithmetic of 30 digits; and where SciPy ends in NaN."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from scipy import special

from emg2vsa.statistics.effect_size import hedges_g, noncentral_f, noncentral_t, share_interval


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
