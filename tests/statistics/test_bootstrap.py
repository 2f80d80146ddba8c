"""BCa bootstrap: its interval from the same resamples by scipy, its coverage, and degenerate samples."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats
from scipy.stats._resampling import BootstrapResult

from emg2vsa.errors import DataError, SettingError
from emg2vsa.statistics.bootstrap import bca, resampled


def mean(x: np.ndarray) -> np.ndarray:
    return np.asarray(np.nanmean(x, axis=(-2, -1)))


def sd(x: np.ndarray) -> np.ndarray:
    return np.asarray(np.nanstd(x, axis=(-2, -1), ddof=1))


def difference(x: np.ndarray) -> np.ndarray:
    return np.asarray(np.nanmean(x[..., 0, :], axis=-1) - np.nanmean(x[..., 1, :], axis=-1))


def largest(x: np.ndarray) -> np.ndarray:
    return np.asarray(np.nanmax(x, axis=(-2, -1)))


DESIGNS = np.random.default_rng(0).exponential(size=(6, 2, 12))
DESIGNS[2:, 1, 8:] = np.nan
PEERS = {mean: lambda x, axis: np.mean(x, axis=axis), sd: lambda x, axis: np.std(x, axis=axis, ddof=1)}


@pytest.mark.parametrize("statistic", [mean, sd])
def test_one_sample_interval_is_scipys_of_the_same_resamples(statistic: object) -> None:
    one = DESIGNS[:, :1]
    found, drawn = bca(one, statistic, 999, 5), resampled(one, statistic, 999, 5)  # type: ignore[arg-type]
    for i in range(6):
        mine = BootstrapResult(None, drawn[i], None)
        peer = stats.bootstrap((one[i, 0],), PEERS[statistic], n_resamples=0, bootstrap_result=mine)  # type: ignore[index]
        np.testing.assert_allclose([found.low[i], found.high[i]], peer.confidence_interval, rtol=1e-11)


def test_two_sample_interval_is_scipys_of_the_same_resamples() -> None:
    found, drawn = bca(DESIGNS, difference, 999, 5, 0.9), resampled(DESIGNS, difference, 999, 5)
    for i, (x, y) in enumerate(DESIGNS):
        peer = stats.bootstrap(
            (x, y[np.isfinite(y)]),
            lambda a, b, axis: np.mean(a, axis=axis) - np.mean(b, axis=axis),
            n_resamples=0,
            bootstrap_result=BootstrapResult(None, drawn[i], None),
            confidence_level=0.9,
        )
        np.testing.assert_allclose([found.low[i], found.high[i]], peer.confidence_interval, rtol=1e-11, atol=1e-14)


def test_resamples_are_drawn_with_replacement_within_their_group() -> None:
    seen = resampled(DESIGNS[2:3], largest, 4000, 1)[0]
    allowed = DESIGNS[2][np.isfinite(DESIGNS[2])]
    assert np.isin(seen, allowed).all()
    # the largest of 20 is drawn unless it is missed by every draw of its own group
    group = DESIGNS[2, np.nanmax(DESIGNS[2], axis=1).argmax()]
    size = np.isfinite(group).sum()
    assert np.mean(seen == allowed.max()) == pytest.approx(1 - (1 - 1 / size) ** size, abs=0.03)
    drawn = resampled(DESIGNS, mean, 4000, 2)
    assert np.std(drawn[0]) == pytest.approx(np.sqrt(np.sum(np.var(DESIGNS[0], axis=1)) / 12) / 2, rel=0.05)


def test_seed_decides_and_batch_does_not() -> None:
    found = bca(DESIGNS, mean, 500, 3)
    again, alone, other = bca(DESIGNS, mean, 500, 3), bca(DESIGNS[4], mean, 500, 3), bca(DESIGNS, mean, 500, 4)
    np.testing.assert_array_equal(found.low, again.low)
    assert (alone.low[0], alone.high[0]) == (found.low[4], found.high[4])
    assert (found.low != other.low).all()


def test_interval_follows_a_monotone_map() -> None:
    """BCa respects transformations: the interval of exp(mean) is exp of the interval but for the acceleration."""
    found, mapped = bca(DESIGNS, mean, 4000, 1), bca(DESIGNS, lambda x: np.exp(mean(x) / 100), 4000, 1)
    np.testing.assert_allclose(np.log(mapped.low) * 100, found.low, rtol=0.01)
    np.testing.assert_allclose(np.log(mapped.high) * 100, found.high, rtol=0.01)


def test_shift_and_scale() -> None:
    found = bca(DESIGNS, mean, 300, 1)
    for scale, shift in ((-1.0, 0.0), (1e-300, 0.0), (1e300, 0.0), (3.0, 1e4)):
        other = bca(DESIGNS * scale + shift, mean, 300, 1)
        ends = np.sort([found.low * scale + shift, found.high * scale + shift], axis=0)
        np.testing.assert_allclose([other.low, other.high], ends, rtol=1e-8)


def test_coverage_beats_percentiles_on_skewed_samples() -> None:
    """Mean of 20 exponential values, nominal .95: percentiles cover about .90, BCa about .92."""
    values = np.random.default_rng(11).exponential(size=(1500, 1, 20))
    found = bca(values, mean, 800, 1)
    drawn = resampled(values, mean, 800, 1)
    low, high = np.quantile(drawn, [0.025, 0.975], axis=1)
    bca_covers = np.mean((found.low <= 1) & (found.high >= 1))
    assert bca_covers > np.mean((low <= 1) & (high >= 1))
    assert 0.90 < bca_covers < 0.96


def test_degenerate_samples() -> None:
    nan, one = np.nan, [[1.0, 2.0, 4.0]]
    equal, single = bca([[2.0, 2.0, 2.0]], mean, 100), bca([[2.0, nan]], mean, 100)
    assert (equal.low[0], equal.high[0]) == (2.0, 2.0)
    assert np.isnan(single.low[0])
    eight = np.arange(8.0)[None]
    outside = bca(eight, lambda x: np.where(np.all(x == eight, axis=(-2, -1)), 99.0, mean(x)), 100, 4)
    undefined = bca(one, lambda x: np.full(x.shape[:-2], nan), 100)
    assert np.isnan([outside.high[0], undefined.low[0], undefined.estimate[0]]).all()
    few = bca(one, lambda x: np.where(sd(x) > 0, mean(x), nan), 500, 1)
    assert 1.0 < few.low[0] < few.high[0] < 4.0


def test_refusals() -> None:
    with pytest.raises(DataError, match="statistic"):
        bca(DESIGNS, lambda x: np.nanmean(x, axis=-1))
    with pytest.raises(SettingError, match="resamples"):
        bca(DESIGNS, mean, 1)
