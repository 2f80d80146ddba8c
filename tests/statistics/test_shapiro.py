"""Shapiro-Wilk beside scipy, a published sample, and what must not change the answer."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from emg2vsa.statistics.shapiro import shapiro_wilk


@pytest.mark.parametrize("n", [3, 4, 5, 6, 7, 10, 11, 12, 20, 50, 300, 5000])
def test_w_and_p_are_scipys_to_nine_digits(n: int) -> None:
    rng = np.random.default_rng(n)
    rows = np.concatenate([rng.standard_normal((6, n)), rng.exponential(size=(6, n))]) * 3e-6 + 1e-5
    found = shapiro_wilk(rows)
    peers = [stats.shapiro(row) for row in rows]
    # scipy takes its normal quantiles to 7 digits
    np.testing.assert_allclose(found.w, [peer.statistic for peer in peers], rtol=3e-9)
    np.testing.assert_allclose(found.p, [peer.pvalue for peer in peers], rtol=1e-7 if n <= 300 else 3e-6)


def test_the_eleven_men_of_shapiro_and_wilk() -> None:
    """Their weights (1965); R prints W = 0.78881, p-value = 0.006704."""
    found = shapiro_wilk([148, 154, 158, 160, 161, 162, 166, 170, 182, 195, 236])
    assert round(found.w[0], 5) == 0.78881
    assert round(found.p[0], 6) == 0.006704


def test_three_values_are_exact() -> None:
    x = np.array([0.0, 1.0, 3.0])
    w = np.max(np.diff(x[[0, 2]])) ** 2 / 2 / np.sum((x - x.mean()) ** 2)
    found = shapiro_wilk(x)
    assert found.w[0] == pytest.approx(w, rel=1e-14)
    assert found.p[0] == pytest.approx(6 / np.pi * (np.arcsin(np.sqrt(w)) - np.arcsin(np.sqrt(0.75))), rel=1e-13)
    assert shapiro_wilk([1.0, 2.0, 3.0]).p[0] == 1.0
    assert shapiro_wilk([1.0, 1.0, 3.0]).p[0] == pytest.approx(0.0, abs=1e-7)


def test_size_is_alpha() -> None:
    found = shapiro_wilk(np.random.default_rng(1).standard_normal((20_000, 10)))
    assert np.mean(found.p < 0.05) == pytest.approx(0.05, abs=0.005)


def test_rows_of_different_length_do_not_mix() -> None:
    rng = np.random.default_rng(3)
    rows = rng.standard_normal((30, 14))
    rows[rng.random((30, 14)) < 0.4] = np.nan
    found = shapiro_wilk(rows)
    for i, row in enumerate(rows):
        alone = shapiro_wilk(row[np.isfinite(row)])
        np.testing.assert_allclose([found.w[i], found.p[i]], [alone.w[0], alone.p[0]], rtol=1e-12)
        assert found.n[i] == np.isfinite(row).sum()


@given(st.integers(0, 2**32 - 1), st.integers(3, 30), st.floats(-1e5, 1e5), st.floats(1e-3, 1e3))
@settings(max_examples=40, deadline=None)
def test_unit_sign_and_order_do_not_matter(seed: int, n: int, shift: float, scale: float) -> None:
    rng = np.random.default_rng(seed)
    x = rng.standard_normal(n)
    w = shapiro_wilk(x).w
    for other in ((x + shift) * scale, -x, rng.permutation(x), x * 1e-300, x * 1e300):
        np.testing.assert_allclose(shapiro_wilk(other).w, w, rtol=1e-8)


@pytest.mark.parametrize("row", [[0.1] * 10, [0.1], [0.1, 0.2], [np.nan, np.nan], [1e300] * 3, [np.inf, 1.0, 2.0]])
def test_no_spread_is_undefined_and_says_so(row: list[float]) -> None:
    found = shapiro_wilk(row)
    assert np.isnan(found.w[0])
    assert np.isnan(found.p[0])
    assert found.outcome().notes[0].startswith("undefined")


def test_notes() -> None:
    assert "repeat" in shapiro_wilk([1.0, 1.0, 2.0, 3.0]).outcome().notes[0]
    assert "extrapolated" in shapiro_wilk(np.random.default_rng(1).standard_normal(5001)).outcome().notes[0]
    plain = shapiro_wilk([1.0, 1.5, 2.0, 3.0]).outcome()
    assert plain.notes == ()
    assert (plain.statistic_name, plain.n) == ("W", 4)
    assert shapiro_wilk(np.empty((0, 4))).w.shape == (0,)
    assert np.isnan(shapiro_wilk(np.empty((2, 0))).w).all()
