"""What must not change an answer: the unit and origin of the values, the order of groups and of values in them, and
whether a value that is not there is NaN or masked."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from emg2vsa.companions.groups import group_tests, pair_tests
from emg2vsa.statistics.anova import brown_forsythe, one_way, welch
from emg2vsa.statistics.bayes import jzs_anova
from emg2vsa.statistics.equivalence import tost
from emg2vsa.statistics.factorial import factorial
from emg2vsa.statistics.kruskal import kruskal
from emg2vsa.statistics.lilliefors import lilliefors
from emg2vsa.statistics.mann_whitney import mann_whitney
from emg2vsa.statistics.mixed import balanced_mixed, unbalanced_mixed
from emg2vsa.statistics.normality import ks_normal, shapiro_wilk
from emg2vsa.statistics.post_hoc import games_howell, lsd
from emg2vsa.statistics.reml import fit_reml
from emg2vsa.statistics.repeated import friedman, rm_anova
from emg2vsa.statistics.trend import trend
from tests.statistics.conftest import study

Answer = Callable[[np.ndarray], np.ndarray]
GROUPS: dict[str, Answer] = {
    "anova": lambda v: one_way(v).f,
    "welch": lambda v: np.array([welch(v).statistic, welch(v).df[1]]),
    "brown-forsythe": lambda v: brown_forsythe(v).statistic,
    "bayes": lambda v: jzs_anova(v).log_bf01,
    "kruskal": lambda v: kruskal(v).h,
    "tost in SDs": lambda v: np.sort(tost(v, 0.9, "sd").p),
    "games-howell": lambda v: np.sort(games_howell(v).p),
    "mann-whitney": lambda v: np.sort(mann_whitney(v).p),
}
"""Of one design (k groups, n), numbers without a unit that no order changes."""
SAMPLES: dict[str, Answer] = {
    "ks": lambda x: ks_normal(x, standardise=True).statistic,
    "lilliefors": lambda x: lilliefors(x).p,
    "shapiro": lambda x: shapiro_wilk(x).statistic,
}
PEOPLE: dict[str, Answer] = {
    "repeated": lambda v: np.array([rm_anova(v).f, rm_anova(v).epsilon_gg, rm_anova(v).people_f]),
    "friedman": lambda v: friedman(v).statistic,
}


@pytest.mark.parametrize("test", GROUPS)
@given(st.integers(0, 2**32 - 1), st.floats(-1e3, 1e3), st.floats(1e-3, 1e3))
@settings(max_examples=12, deadline=None)
def test_of_groups(test: str, seed: int, shift: float, scale: float) -> None:
    rng = np.random.default_rng(seed)
    values = rng.standard_normal((4, 7)) + 0.4 * np.arange(4)[:, None]
    values[np.arange(7) >= rng.integers(3, 8, (4, 1))] = np.nan
    wanted = GROUPS[test](values)
    others = (values * scale + shift, -values, values * 1e-300, values * 1e300, values[rng.permutation(4)])
    for other in (*others, rng.permuted(values, axis=1)):
        np.testing.assert_allclose(GROUPS[test](other), wanted, rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize("test", SAMPLES)
@given(st.integers(0, 2**32 - 1), st.floats(-1e5, 1e5), st.floats(1e-3, 1e3))
@settings(max_examples=12, deadline=None)
def test_of_samples(test: str, seed: int, shift: float, scale: float) -> None:
    rng = np.random.default_rng(seed)
    x = rng.standard_normal(10)
    for other in ((x + shift) * scale, -x, rng.permutation(x), x * 1e-300, x * 1e300):
        np.testing.assert_allclose(SAMPLES[test](other), SAMPLES[test](x), rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("test", PEOPLE)
@given(st.integers(0, 2**32 - 1), st.floats(-1e3, 1e3))
@settings(max_examples=12, deadline=None)
def test_of_people(test: str, seed: int, shift: float) -> None:
    rng = np.random.default_rng(seed)
    x = rng.standard_normal((8, 4)) + rng.standard_normal((8, 1))
    for other in ((x + shift) * 3, -x, x * 1e-300, x * 1e300, x[rng.permutation(8)], x[:, rng.permutation(4)]):
        np.testing.assert_allclose(PEOPLE[test](other), PEOPLE[test](x), rtol=1e-6)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_ranks_know_no_monotone_map(seed: int) -> None:
    values = np.floor(np.random.default_rng(seed).uniform(0, 8, (4, 9)))
    for answer in (GROUPS["kruskal"], GROUPS["mann-whitney"], PEOPLE["friedman"]):
        for other in (np.exp(values), values**3 + values):
            np.testing.assert_allclose(answer(other), answer(values), rtol=1e-13)


@pytest.mark.parametrize("offset", [2.0**30, 2.0**42])
def test_an_origin_far_away_costs_no_digit(offset: float) -> None:
    """Sixteenths keep all their bits beside 2^42, so that the answers must not move."""
    values = np.round(np.random.default_rng(0).standard_normal((3, 10)) * 16) / 16
    near, far = (pair_tests(v, group_tests(v)) for v in (values, values + offset))
    for test in ("lsd", "tukey", "games_howell"):
        for name in ("p", "low"):
            wanted = getattr(getattr(near, test), name)
            np.testing.assert_allclose(getattr(getattr(far, test), name), wanted, rtol=1e-12)
    np.testing.assert_allclose(far.g, near.g, rtol=1e-12)


def test_models_over_people_keep_their_digits_at_a_large_offset() -> None:
    y = np.round(np.random.default_rng(0).standard_normal((6, 3, 4)) * 2**10) / 2**10
    far = y + 2.0**30
    assert balanced_mixed(far).f == pytest.approx(balanced_mixed(y).f, rel=1e-12)
    assert rm_anova(far.mean(axis=2)).f == pytest.approx(rm_anova(y.mean(axis=2)).f, rel=1e-12)
    y[0, 0, 0] = np.nan
    near, other = unbalanced_mixed(fit_reml(y)), unbalanced_mixed(fit_reml(y + 2.0**30))  # type: ignore[arg-type]
    assert other.f == pytest.approx(near.f, rel=1e-12)
    assert other.pairs.p == pytest.approx(near.pairs.p, rel=1e-11)


MASKED: dict[str, Answer] = {
    **GROUPS,
    **{name: lambda v, of=of: of(v.T) for name, of in PEOPLE.items()},
    "lsd": lambda v: lsd(one_way(v)).p,
    "shapiro": lambda v: shapiro_wilk(v).p,
    "ks": lambda v: ks_normal(v, standardise=False).p,
    "factorial": lambda v: factorial(v, {"a": np.repeat([0, 1, 2], 6)}).p,
    "trend": lambda v: np.array(
        trend(np.repeat(["a", "b", "c"], 6), np.full(18, "x"), np.tile(np.arange(6.0), 3), v.ravel()).p
    ),
    "unbalanced": lambda v: np.array(unbalanced_mixed(fit_reml(v.reshape(3, 2, 3))).p),  # type: ignore[arg-type]
}


@pytest.mark.parametrize("test", MASKED)
def test_masked_values_are_no_values(test: str) -> None:
    values = np.random.default_rng(2).standard_normal((3, 6))
    masked = np.ma.masked_array(values.copy(), mask=np.zeros((3, 6), dtype=bool))
    masked[0, 1] = 1e6
    masked[0, 1] = np.ma.masked
    masked[2, 4] = np.ma.masked
    values[0, 1] = values[2, 4] = np.nan
    np.testing.assert_array_equal(MASKED[test](masked), MASKED[test](values))


@pytest.mark.parametrize(("shift", "scale"), [(1e6, 1.0), (0.0, 1e-150), (0.0, 1e150), (-3.0, 1e-6)])
@pytest.mark.parametrize("gap", [False, True])
def test_unit_origin_and_order_of_the_mixed_model(shift: float, scale: float, gap: bool) -> None:
    y = study(4, 0.4, 0.3, (6, 3, 4))
    if gap:
        y[0, 1] = np.nan
    first, moved, turned = (
        unbalanced_mixed(fit_reml(v)) if gap else balanced_mixed(v)  # type: ignore[arg-type]
        for v in (y, (y + shift) * scale, y[::-1, :, ::-1])
    )
    for other, unit in ((moved, scale), (turned, 1.0)):
        assert other.f == pytest.approx(first.f, rel=1e-8)
        np.testing.assert_allclose(other.variance / unit**2, first.variance, rtol=1e-7)
        assert other.ratio_high == pytest.approx(first.ratio_high, rel=1e-6)
