"""Standard deviations of the mixed model, their intervals and its residuals: against lme4 and a dense likelihood."""

from __future__ import annotations

import json

import mpmath
import numpy as np
import pytest
from scipy import special, stats

from emg2vsa.statistics.mixed import balanced_mixed
from emg2vsa.statistics.mixed_variances import MixedResiduals, MixedVariances, mixed_residuals, mixed_variances
from emg2vsa.statistics.reml import by_variances, cells_of, lowest
from emg2vsa.statistics.unbalanced_mixed import UnbalancedMixed, unbalanced_mixed
from tests.statistics.conftest import LMER, STUDIES, clusters, dense_minus_2_reml, study


def variances(values: np.ndarray) -> MixedVariances:
    found = mixed_variances(values)
    assert found is not None
    return found


def residuals(values: np.ndarray) -> MixedResiduals:
    found = mixed_residuals(values)
    assert found is not None
    return found


@pytest.mark.parametrize("name", STUDIES)
def test_intervals_are_those_of_lme4s_restricted_likelihood(name: str) -> None:
    lme4 = json.loads((LMER / "profile.json").read_text())[name]
    found = variances(clusters(name).values)
    for key, ends in (("sd_low", found.low), ("sd_high", found.high)):
        np.testing.assert_allclose(ends, lme4[key], rtol=1e-10, atol=1e-10)
    for key, ends in (("ratio_low", found.ratio_low), ("ratio_high", found.ratio_high)):
        np.testing.assert_allclose(ends, lme4[key], rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("name", STUDIES)
def test_fitted_values_are_those_of_lme4(name: str) -> None:
    """As near as lme4 stops to the best variances."""
    lme4 = json.loads((LMER / "profile.json").read_text())[name]
    np.testing.assert_allclose(residuals(clusters(name).values).fitted, lme4["fitted"], atol=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "source"), [("interior.csv", 0), ("interior.csv", 1), ("no_participants.csv", 2)])
def test_ends_in_thirty_digits(name: str, source: int) -> None:
    """At an end, the dense likelihood lies a quantile of chi squared above its best: the others at their best."""
    of = clusters(name)
    found, whole = variances(of.values), unbalanced_mixed(of.values)
    assert isinstance(whole, UnbalancedMixed)
    quantile = special.chdtri(1, 0.05)

    def dense(variance: list[float]) -> float:
        with mpmath.workdps(30):
            return float(dense_minus_2_reml(of, [mpmath.mpf(v) for v in variance]) - mpmath.mpf(whole.minus_2_reml))

    end = found.high[source] ** 2
    others = [i for i in range(3) if i != source]
    best = _best_of_others(of.values, source, end)
    at = np.empty(3)
    at[source], at[others] = end, best
    assert dense(at.tolist()) == pytest.approx(quantile, abs=1e-9)
    for i in others:  # any other choice is higher: the end is the profile's
        up = at.copy()
        up[i] += 1e-4
        assert dense(up.tolist()) > quantile


def _best_of_others(values: np.ndarray, source: int, end: float) -> np.ndarray:
    cells, _, unit, _ = cells_of(values)
    start = np.full(3, np.ldexp(1.0, -2 * unit))
    start[source] = np.ldexp(end, -2 * unit)
    best = lowest(by_variances(cells), start, np.arange(3) != source, search=True)
    return np.ldexp(best[np.arange(3) != source], 2 * unit)


def test_without_gaps_the_estimates_are_the_closed_form() -> None:
    for seed in range(3):
        y = study(seed, 0.5, 0.3)
        np.testing.assert_allclose(variances(y).sd, np.sqrt(balanced_mixed(y).variance[0]), rtol=1e-11)


def test_a_variance_at_the_boundary_is_said() -> None:
    found = variances(clusters("no_participants.csv").values)
    assert found.sd[0] == found.low[0] == 0 < found.high[0]
    notes = [outcome.notes for outcome in found.outcomes()]
    assert "variance of 0" in notes[0][0]
    assert "variance of 0" in notes[3][0]
    assert notes[1] == notes[2] == ()


@pytest.mark.parametrize(("shift", "scale"), [(1e6, 1.0), (0.0, 1e-150), (0.0, 1e150), (-3.0, 1e-6)])
def test_unit_and_origin(shift: float, scale: float) -> None:
    y = study(4, 0.4, 0.3, (6, 3, 4))
    y[0, 1] = np.nan
    found, other = variances(y), variances((y + shift) * scale)
    np.testing.assert_allclose(other.high / scale, found.high, rtol=1e-7)
    np.testing.assert_allclose(other.ratio_high, found.ratio_high, rtol=1e-7)
    np.testing.assert_allclose(residuals((y + shift) * scale).residual, residuals(y).residual, atol=1e-7)


def test_a_study_that_cannot_bear_the_model_has_neither() -> None:
    for values in (np.ones((4, 3, 2)), np.full((3, 2, 2), np.nan), np.random.default_rng(0).random((1, 3, 2))):
        assert mixed_variances(values) is None
        assert mixed_residuals(values) is None


@pytest.mark.slow
def test_intervals_cover() -> None:
    truth = np.array([0.6, 0.3, 1.0])
    inside = np.zeros(3)
    for seed in range(300):
        y = study(seed, 0.6, 0.3, (10, 4, 5))
        y.ravel()[np.random.default_rng(seed).choice(y.size, 30, replace=False)] = np.nan
        found = variances(y)
        inside += (found.low <= truth) & (truth <= found.high)
    assert (inside / 300 > 0.91).all()
    assert (inside / 300 < 0.985).all()


def test_residuals_lie_on_the_line_and_their_tests_are_no_surprise() -> None:
    found = residuals(study(0, 0.5, 0.3))
    spread = np.sqrt(1 - 70 / 700)  # 70 cells were fitted
    assert stats.linregress(found.quantile, found.residual).slope == pytest.approx(spread, abs=0.03)
    normal, level = found.outcomes()
    assert normal.statistic == pytest.approx(stats.shapiro(found.residual).statistic, rel=1e-8)
    rho = stats.spearmanr(np.abs(found.residual), found.fitted)
    assert level.effect_size == pytest.approx(rho.statistic, rel=1e-12)
    assert level.p == pytest.approx(rho.pvalue, rel=1e-9)


def test_scatter_that_grows_with_the_level_is_seen() -> None:
    y = 5 + study(0, 1.0, 0.0)
    y += (y - y.mean(axis=2, keepdims=True)) * 0.5 * (y.mean(axis=2, keepdims=True) - 5)
    level = residuals(y).outcomes()[1]
    assert level.p is not None
    assert level.p < 1e-6
    assert level.effect_size is not None
    assert level.effect_size > 0.2
