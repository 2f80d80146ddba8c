"""Power of repeated measures: published anchors, and an independent series."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import special

from emg2vsa.errors import SettingError
from emg2vsa.statistics.power import MEANING, n_for_power, power_rm, power_table


def mixture_power(n: int, m: int, f: float, rho: float, epsilon: float, alpha: float) -> float:
    """Noncentral F as a Poisson mixture of beta probabilities."""
    df1, half = (m - 1) * epsilon, f * f * n * m * epsilon / (1 - rho) / 2
    df2 = (n - 1) * df1
    x = special.betainccinv(df1 / 2, df2 / 2, alpha)
    j = np.arange(int(half + 40 * np.sqrt(half + 1) + 60))
    mass = np.exp(special.xlogy(j, half) - half - special.gammaln(j + 1))
    return float(np.sum(mass * special.betaincc(df1 / 2 + j, df2 / 2, x)))


def test_the_papers_fourteen() -> None:
    assert abs(power_rm(14, 10, 0.25, 0.5, 1.0, 0.05) - 0.819421399316) < 1e-12
    assert n_for_power(10) == 14
    assert power_rm(13, 10) < 0.8


@pytest.mark.parametrize(
    ("n", "m", "rho", "epsilon", "power"),
    [
        (13, 10, 0.5, 1.0, 0.780756), (14, 5, 0.5, 1.0, 0.604379), (21, 5, 0.5, 1.0, 0.815886),
        (20, 5, 0.5, 1.0, 0.792763), (14, 50, 0.5, 1.0, 0.999914), (14, 10, 0.5, 0.75, 0.7236),
        (14, 10, 0.5, 0.5, 0.5850), (14, 10, 0.0, 1.0, 0.463), (14, 10, 0.3, 1.0, 0.645), (14, 10, 0.7, 1.0, 0.975),
        (14, 5, 0.8, 1.0, 0.964),
    ],
)  # fmt: skip
def test_table_of_the_statistics_notes(n: int, m: int, rho: float, epsilon: float, power: float) -> None:
    places = len(str(power)) - 2
    assert round(float(power_rm(n, m, rho=rho, epsilon=epsilon)), places) == power


def test_spss_convention() -> None:
    assert round(float(power_rm(14, 10, convention="spss")), 3) == 0.386
    assert n_for_power(10, convention="spss") == 30
    assert power_rm(14, 10, rho=0.0, convention="spss") == power_rm(14, 10, rho=0.9, convention="spss")


@given(
    st.integers(2, 40), st.integers(2, 20), st.floats(0, 0.6), st.floats(0, 0.8), st.floats(0, 1), st.floats(1e-3, 0.3)
)
@settings(max_examples=60, deadline=None)
def test_is_the_poisson_mixture(n: int, m: int, f: float, rho: float, share: float, alpha: float) -> None:
    epsilon = 1 / (m - 1) + share * (1 - 1 / (m - 1))
    assert abs(power_rm(n, m, f, rho, epsilon, alpha) - mixture_power(n, m, f, rho, epsilon, alpha)) < 1e-11


def test_next_to_no_effect_has_power_alpha() -> None:
    np.testing.assert_allclose(
        power_rm(2, 2, [0.0, 1e-170, 1.8e-49, 1e-15, 1e-9, 1e-7], 0.0, 1.0, 0.25), 0.25, atol=1e-12
    )


def test_no_effect_has_power_alpha() -> None:
    np.testing.assert_allclose(power_rm([2, 14, 100], 10, f=0.0, alpha=0.05), 0.05, rtol=1e-12)


def test_power_grows_with_people() -> None:
    assert (np.diff(power_rm(np.arange(2, 60), 5)) > 0).all()


def test_number_needed_is_the_smallest() -> None:
    for m, f, target in ((5, 0.25, 0.8), (3, 0.1, 0.9), (2, 1.5, 0.5), (50, 0.25, 0.8)):
        n = n_for_power(m, f, power=target)
        assert power_rm(n, m, f) >= target
        assert n == 2 or power_rm(n - 1, m, f) < target


def test_nobody_suffices_without_an_effect() -> None:
    assert n_for_power(10, f=0.0) == 0


def test_table_over_rho_and_epsilon() -> None:
    table = power_table(14, 10)
    assert table.power.shape == table.people.shape == (4, 3)
    assert table.people[2].tolist() == [21, 17, 14]
    assert table.people[:, 2].tolist() == [26, 19, 14, 9]
    assert (np.diff(table.power, axis=0) > 0).all()
    assert (np.diff(table.power, axis=1) > 0).all()


def test_two_measurements_are_always_spherical() -> None:
    np.testing.assert_array_equal(power_table(14, 2).epsilon, [1.0])


def test_sentence_states_the_computed_numbers() -> None:
    assert f"{power_rm(14, 10):.3f}"[1:] in MEANING
    assert f"{power_rm(14, 5):.3f}"[1:] in MEANING
    assert f" {n_for_power(5)} are needed" in MEANING


@pytest.mark.parametrize(
    "bad",
    [{"n": 1}, {"m": 1}, {"f": -0.1}, {"rho": 1.0}, {"epsilon": 0.05}, {"epsilon": 1.1}, {"alpha": 0.0}, {"f": np.nan}],
)
def test_impossible_designs_are_refused(bad: dict[str, float]) -> None:
    with pytest.raises(SettingError, match=f"power, {next(iter(bad))}"):
        power_rm(**{"n": 14, "m": 10} | bad)  # type: ignore[arg-type]


def test_impossible_target_is_refused() -> None:
    with pytest.raises(SettingError, match="target"):
        n_for_power(10, power=1.0)
