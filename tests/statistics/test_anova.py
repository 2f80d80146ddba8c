"""One-way ANOVA and LSD: NIST, scipy, and what must not change the answer."""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from emg2vsa.errors import DataError
from emg2vsa.statistics.anova import one_way
from emg2vsa.statistics.post_hoc import lsd

CEILING = {
    "SiRstv": 13.1, "SmLs01": 15, "SmLs02": 15, "SmLs03": 15, "AtmWtAg": 10.2, "SmLs04": 10.4,
    "SmLs05": 10.2, "SmLs06": 10.2, "SmLs07": 4.4, "SmLs08": 4.2, "SmLs09": 4.2,
}  # fmt: skip
"""Digits of F that exact arithmetic gives on the doubles nearest to the decimal data."""


def nist(path: Path) -> tuple[list[list[str]], list[str]]:
    """Groups of decimal numbers as text, and the numbers of the certified table from the between row on."""
    lines = path.read_text().splitlines()
    rows = [line.split() for line in lines[60:] if len(line.split()) == 2]
    groups: dict[str, list[str]] = {}
    for group, value in rows:
        groups.setdefault(group, []).append(value)
    certified = " ".join(line for line in lines[40:60] if line.strip())
    numbers = [word for word in certified.split() if any(c.isdigit() for c in word)]
    return list(groups.values()), numbers


def digits(value: float, certified: str) -> float:
    error = abs(Decimal(float(value)) - Decimal(certified)) / abs(Decimal(certified))
    return 15.0 if error == 0 else min(15.0, -float(error.log10()))


@pytest.mark.parametrize("name", CEILING)
def test_nist_reaches_what_doubles_allow(name: str, shared_data: Callable[[str], Path]) -> None:
    groups, certified = nist(shared_data(f"nist/nist_anova/{name}.dat"))
    anova = one_way(np.array(groups, dtype=np.float64))
    assert digits(anova.f[0], certified[3]) >= CEILING[name] - 0.1
    assert anova.df1[0] == int(certified[0])
    assert anova.df2[0] == int(certified[4])


@pytest.mark.parametrize("name", CEILING)
def test_nist_from_decimal_text_is_right_to_14_digits(name: str, shared_data: Callable[[str], Path]) -> None:
    groups, certified = nist(shared_data(f"nist/nist_anova/{name}.dat"))
    anova = one_way([[Decimal(value) for value in group] for group in groups])
    assert digits(anova.f[0], certified[3]) >= 14.5
    assert digits(anova.eta2[0], certified[7]) >= 14.4
    assert digits(anova.sd[0], certified[8]) >= 14.4


def unbalanced(seed: int, k: int = 5, n: int = 10) -> np.ndarray:
    rng = np.random.default_rng(seed)
    values = rng.standard_normal((k, n)) + 0.4 * np.arange(k)[:, None]
    values[np.arange(n) >= rng.integers(2, n + 1, (k, 1))] = np.nan
    return values


def test_batch_of_unbalanced_designs_is_scipys() -> None:
    designs = np.array([unbalanced(seed) for seed in range(30)])
    anova = one_way(designs)
    for i, design in enumerate(designs):
        peer = stats.f_oneway(*(group[np.isfinite(group)] for group in design))
        np.testing.assert_allclose([anova.f[i], anova.p[i]], peer, rtol=1e-12)
    np.testing.assert_allclose(anova.mean, np.nanmean(designs, axis=2), rtol=1e-13)
    np.testing.assert_array_equal(anova.count, np.isfinite(designs).sum(axis=2))


def test_empty_groups_do_not_count() -> None:
    values = unbalanced(1)
    padded = np.vstack([np.full(10, np.nan), values[:2], np.full(10, np.nan), values[2:]])
    with_empty, without = one_way(padded), one_way(values)
    assert with_empty.df1[0] == 4
    np.testing.assert_allclose(with_empty.f, without.f, rtol=1e-14)
    assert np.isnan(lsd(with_empty).p[0, 0])


@given(st.integers(0, 2**32 - 1), st.floats(-1e3, 1e3), st.floats(1e-3, 1e3))
@settings(max_examples=40, deadline=None)
def test_shift_scale_and_order_do_not_matter(seed: int, shift: float, scale: float) -> None:
    values = unbalanced(seed)
    rng = np.random.default_rng(seed)
    f = one_way(values).f
    for other in (values * scale + shift, values[rng.permutation(5)], rng.permuted(values, axis=1), -values):
        np.testing.assert_allclose(one_way(other).f, f, rtol=1e-7)


@pytest.mark.parametrize("scale", [1e-300, 1e300])
def test_extreme_scales(scale: float) -> None:
    values = unbalanced(7)
    anova, extreme = one_way(values), one_way(values * scale)
    np.testing.assert_allclose(extreme.f, anova.f, rtol=1e-12)
    np.testing.assert_allclose(lsd(extreme).p, lsd(anova).p, rtol=1e-10)
    np.testing.assert_allclose(extreme.sd / scale, anova.sd, rtol=1e-13)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_f_is_t_squared_with_two_groups(seed: int) -> None:
    anova = one_way(unbalanced(seed, k=2))
    pair = lsd(anova)
    np.testing.assert_allclose(anova.f[0], pair.statistic[0, 0] ** 2, rtol=1e-10)
    np.testing.assert_allclose(anova.p[0], pair.p[0, 0], rtol=1e-9)


def test_lsd_pools_the_sd_of_all_groups() -> None:
    values = unbalanced(3)
    anova = one_way(values)
    pairs = lsd(anova, 0.99)
    groups = [group[np.isfinite(group)] for group in values]
    df = sum(map(len, groups)) - 5
    sd = np.sqrt(sum(((g - g.mean()) ** 2).sum() for g in groups) / df)
    assert pairs.first.size == 10
    for q, (i, j) in enumerate(zip(pairs.first, pairs.second, strict=True)):
        se = sd * np.sqrt(1 / groups[i].size + 1 / groups[j].size)
        difference = groups[i].mean() - groups[j].mean()
        np.testing.assert_allclose(pairs.statistic[0, q], difference / se, rtol=1e-11)
        np.testing.assert_allclose(pairs.p[0, q], 2 * stats.t.sf(abs(difference / se), df), rtol=1e-11)
        np.testing.assert_allclose(pairs.high[0, q], difference + stats.t.ppf(0.995, df) * se, rtol=1e-11)
    outcome = pairs.outcome(0, 9)
    assert outcome.n == groups[3].size + groups[4].size
    assert outcome.confidence == 0.99
    assert outcome.interval is not None
    assert outcome.interval[0] < (outcome.estimate or 0) < outcome.interval[1]


def test_interval_excludes_zero_exactly_when_p_is_small() -> None:
    pairs = lsd(one_way(np.array([unbalanced(seed) for seed in range(40)])), 0.95)
    np.testing.assert_array_equal((pairs.low > 0) | (pairs.high < 0), pairs.p < 0.05)


@pytest.mark.parametrize(
    ("values", "note"),
    [
        ([[0.1] * 3, [0.1] * 3], "undefined: all values are equal"),
        ([[1.0, 2.0, 3.0]], "undefined: 1 group"),
        ([[np.nan], [np.nan]], "undefined: 0 group"),
        ([[1.0], [2.0], [3.0]], "undefined: one value a group"),
        ([[7.0]], "undefined: 1 group"),
    ],
)
def test_undefined_designs_say_why(values: list[list[float]], note: str) -> None:
    anova = one_way(values)
    outcome = anova.outcome()
    assert np.isnan(anova.f[0])
    assert np.isnan(anova.p[0])
    assert outcome.notes[0].startswith(note)
    if len(values) > 1:  # one group has no pairs: refused
        assert np.isnan(lsd(anova).p).all()


def test_constant_groups_that_differ() -> None:
    anova = one_way([[0.1] * 3, [0.2] * 3])
    assert np.isinf(anova.f[0])
    assert anova.p[0] == 0
    assert anova.eta2[0] == 1
    assert "equal" in anova.outcome().notes[0]
    assert lsd(anova).p[0, 0] == 0


def test_no_design() -> None:
    anova = one_way(np.empty((0, 2, 1)))
    assert anova.f.shape == (0,)
    assert lsd(anova).p.shape == (0, 1)


def test_exact_types_and_gaps() -> None:
    exact = one_way([[Fraction(1, 3), 2, None], [Decimal("4.5"), float("nan"), 5]])
    np.testing.assert_allclose(exact.f, one_way([[1 / 3, 2, np.nan], [4.5, np.nan, 5]]).f, rtol=1e-14)
    np.testing.assert_allclose(exact.mean[0], [7 / 6, 4.75], rtol=1e-15)


@pytest.mark.parametrize("values", [[[1, 2], [3]], [1, 2, 3], [["a", "b"], ["c", "d"]], [[], []], [[Decimal(1), "x"]]])
def test_what_is_not_a_design_is_refused(values: list[object]) -> None:
    with pytest.raises(DataError, match="analysis of variance"):
        one_way(values)  # type: ignore[arg-type]
