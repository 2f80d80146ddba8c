"""Equivalence: the two one-sided tests of scipy, their interval, and a power from simulation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import integrate, stats

from emg2vsa.errors import DataError, SettingError
from emg2vsa.statistics.equivalence import Kind, tost
from emg2vsa.statistics.post_hoc import pair_numbers
from emg2vsa.statistics.power_pairs import margin_for_power, power_tost

DESIGNS = np.random.default_rng(2).standard_normal((6, 3, 9)) + 0.4 * np.arange(3)[:, None]
DESIGNS[2, 1, 5:] = np.nan


def scipys(x: np.ndarray, y: np.ndarray, margin: float, kind: str) -> tuple[float, float, float]:
    """p and the 90 % interval."""
    if kind == "paired":
        both = np.isfinite(x) & np.isfinite(y)
        test = stats.ttest_rel
        x, y = x[both], y[both]
        low, high = (
            test(x + side, y, alternative=way).pvalue for side, way in ((margin, "greater"), (-margin, "less"))
        )
        interval = test(x, y).confidence_interval(0.9)
    else:
        x, y, equal = x[np.isfinite(x)], y[np.isfinite(y)], kind == "pooled"
        low = stats.ttest_ind(x + margin, y, equal_var=equal, alternative="greater").pvalue
        high = stats.ttest_ind(x - margin, y, equal_var=equal, alternative="less").pvalue
        interval = stats.ttest_ind(x, y, equal_var=equal).confidence_interval(0.9)
    return max(low, high), interval.low, interval.high


@pytest.mark.parametrize("kind", ["pooled", "welch", "paired"])
def test_p_and_interval_are_scipys(kind: Kind) -> None:
    found = tost(DESIGNS, 0.8, kind)
    for i, design in enumerate(DESIGNS):
        for j, (a, b) in enumerate(zip(*pair_numbers(len(design)), strict=True)):
            peer = scipys(design[a], design[b], 0.8, kind)
            np.testing.assert_allclose([found.p[i, j], found.low[i, j], found.high[i, j]], peer, rtol=1e-11)


@pytest.mark.parametrize("shift", [-0.3, 0.0, 0.3])
def test_t_is_that_of_the_side_that_is_harder_to_reject(shift: float) -> None:
    """At a difference of 0 both sides are equally hard, and the upper one is told."""
    x = np.array([1.0, 2.0, 4.0, 5.0])
    found = tost(np.stack([x + shift, x[::-1]])[None], 0.8, "pooled")
    margin = 0.8 if shift < 0 else -0.8
    peer = stats.ttest_ind(x + shift + margin, x[::-1], equal_var=True).statistic
    assert found.t[0, 0] == pytest.approx(peer, rel=1e-12)


@given(st.integers(0, 2**32 - 1), st.floats(0.05, 3), st.floats(0.01, 0.4))
@settings(max_examples=40, deadline=None)
def test_equivalent_exactly_where_the_interval_is_inside(seed: int, margin: float, alpha: float) -> None:
    values = np.random.default_rng(seed).standard_normal((4, 2, 8))
    for kind in ("pooled", "welch", "paired"):
        found = tost(values, margin, kind, alpha=alpha)
        inside = (found.low > -margin) & (found.high < margin)
        np.testing.assert_array_equal(found.p < alpha, inside)


@given(st.integers(0, 2**32 - 1), st.floats(-1e4, 1e4), st.sampled_from([1e-300, 1e-6, 1.0, 1e300]))
@settings(max_examples=30, deadline=None)
def test_shift_scale_and_order_do_not_matter(seed: int, shift: float, scale: float) -> None:
    rng = np.random.default_rng(seed)
    values = rng.standard_normal((2, 3, 7))
    for kind in ("pooled", "welch", "paired"):
        found = tost(values, 0.9, kind)
        np.testing.assert_allclose(tost((values + shift) * scale, 0.9 * scale, kind).p, found.p, rtol=1e-8)
        mirrored = tost(-values, 0.9, kind)
        np.testing.assert_allclose([mirrored.p, -mirrored.t], [found.p, found.t], rtol=1e-12)
        np.testing.assert_allclose(tost(values[:, :, rng.permutation(7)], 0.9, kind).p, found.p, rtol=1e-10)


def test_margin_in_sds_is_that_many_sds_and_says_so() -> None:
    for kind in ("pooled", "welch", "paired"):
        found = tost(DESIGNS, 0.8, kind, "sd")
        np.testing.assert_allclose(found.margin, 0.8 * found.of.sd, rtol=1e-15)
        data = tost(DESIGNS[0], float(found.margin[0, 1]), kind)
        assert data.p[0, 1] == found.p[0, 1]
        assert "SD" in found.outcome().notes[1]
    x, y = DESIGNS[0, :2]
    assert tost(DESIGNS, 1.0, "pooled").of.sd[0, 0] == pytest.approx(np.sqrt((x.var(ddof=1) + y.var(ddof=1)) / 2))
    assert tost(DESIGNS, 1.0, "paired").of.sd[0, 0] == pytest.approx(np.std(x - y, ddof=1))


def test_power_of_the_statistics_notes() -> None:
    assert [round(float(x), 3) for x in power_tost([0.5, 1.0], 10, 10)] == [0.001, 0.391]
    assert round(float(margin_for_power(0.8, 10, 10)), 2) == 1.36
    assert power_tost(margin_for_power(0.8, [3, 10], 10), [3, 10], 10) == pytest.approx(0.8, abs=1e-12)


@pytest.mark.parametrize(("margin", "n1", "n2", "delta"), [(0.9, 10, 10, 0.0), (0.6, 14, 30, -0.4), (1.5, 2, 2, 0.1)])
def test_power_is_the_double_integral(margin: float, n1: int, n2: int, delta: float) -> None:
    df, se = n1 + n2 - 2, np.sqrt(1 / n1 + 1 / n2)
    t = stats.t.ppf(0.95, df)

    def inside(s: float) -> float:
        reach = margin - t * se * s
        law = stats.norm(delta, se)
        return float((law.cdf(reach) - law.cdf(-reach)) * stats.chi.pdf(s, df, scale=df**-0.5)) if reach > 0 else 0.0

    peer, _ = integrate.quad(inside, 0, margin / (t * se), epsabs=1e-13, limit=200)
    assert power_tost(margin, n1, n2, delta) == pytest.approx(peer, abs=1e-9)


def test_power_is_how_often_it_happens() -> None:
    values = np.random.default_rng(5).standard_normal((20_000, 2, 10))
    assert np.mean(tost(values, 1.36).p < 0.05) == pytest.approx(float(power_tost(1.36, 10, 10)), abs=0.01)
    paired = np.mean(tost(np.stack([values[:, 0] + 0.2, np.zeros((20_000, 10))], axis=1), 0.9, "paired").p < 0.05)
    assert paired == pytest.approx(float(power_tost(0.9, 10, delta_sd=0.2)), abs=0.01)
    assert power_tost(0.0, 10, 10) == 0.0


def test_hostile_designs_are_undefined_and_say_so() -> None:
    nan = np.nan
    hostile = np.array([[[1.0, 1.0], [1.0, 1.0]], [[1.0, 2.0], [nan, nan]], [[1.0, nan], [2.0, nan]], [[nan, nan]] * 2])
    for kind in ("pooled", "welch", "paired"):
        found = tost(hostile, 1.0, kind)
        assert np.isnan(found.p).all()
        assert all("undefined" in found.outcome(i).notes[0] for i in range(4))
    assert tost([[1.0, np.inf, 2.0], [1.0, 2.0, 3.0]], 1.0).of.n[0, 0] == 5


def test_impossible_settings_are_refused() -> None:
    for bad in ({"margin": 0.0}, {"margin": np.nan}, {"margin": 1.0, "alpha": 0.5}, {"margin": 1.0, "kind": "other"}):
        with pytest.raises(SettingError, match="equivalence"):
            tost(DESIGNS, **bad)  # type: ignore[arg-type]
    with pytest.raises(SettingError, match="degree of freedom"):
        power_tost(1.0, 1)
    with pytest.raises(SettingError, match="power"):
        margin_for_power(1.0, 10)
    with pytest.raises(DataError):
        tost([1.0, 2.0], 1.0)
