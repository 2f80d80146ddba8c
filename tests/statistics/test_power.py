"""Power of repeated measures, of paired t tests and of equality: published anchors, simulation, independent series."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import integrate, special, stats

from emg2vsa.cli import main
from emg2vsa.errors import SettingError
from emg2vsa.statistics.power import (
    MEANING,
    fewest_people,
    least_for_power,
    n_for_power,
    power_paired,
    power_rm,
    power_table,
    power_tost,
)


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


def test_paired_by_simulation() -> None:
    y = 0.6 + np.random.default_rng(1).standard_normal((20_000, 12))
    assert np.mean(stats.ttest_1samp(y, 0, axis=1).pvalue < 0.05) == pytest.approx(power_paired(0.6, 12), abs=0.01)


def test_gpowers_paired_example() -> None:
    """G*Power, "means: difference between two dependent means": d_z = .5, alpha .05, power .8 need 34 people."""
    assert fewest_people(lambda n: power_paired(0.5, n), 0.8) == 34
    assert power_paired(0.5, 34) == pytest.approx(0.8077775, abs=1e-6)
    assert power_paired(least_for_power(lambda x: power_paired(x, 14), 0.8), 14) == pytest.approx(0.8, abs=1e-12)


@pytest.mark.parametrize(("cv", "n", "power"), [(0.3, 40, 0.815845), (0.2, 20, 0.834680)])
def test_published_powers_of_bioequivalence(cv: float, n: int, power: float) -> None:
    """PowerTOST's documentation: 2 x 2 crossover, limits .80 to 1.25, true ratio .95."""
    group_sd = np.sqrt(np.log(1 + cv**2) / 2)
    found = power_tost(np.log(1.25) / group_sd, n // 2, n // 2, np.log(0.95) / group_sd)
    assert found == pytest.approx(power, abs=5e-7)


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


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["--design", "paired"], {"power": 0.4102, "participants_needed": 34, "smallest_effect": 0.810}),
        (["--design", "equal-paired", "--margin", "0.9", "--participants", "10"], {"power": 0.6733}),
        (["--design", "equal-groups", "--margin", "1", "--participants", "10"],
         {"power": 0.391, "smallest_margin": 1.3616}),
    ],
)  # fmt: skip
def test_the_command(arguments: list[str], expected: dict[str, float], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tools", "power", *arguments, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    for key, value in expected.items():
        assert found[key] == pytest.approx(value, abs=6e-4)
    assert main(["tools", "power", *arguments]) == 0
    assert f"power {found['power']:.4f}" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--margin", "1"], "a design that tests equality"),
        (["--design", "paired", "--sensitivity"], "the design repeated"),
        (["--design", "paired", "--effect", "inf"], "a finite number"),
        (["--effect", "inf"], "an effect size of 0 or more"),
        (["--design", "equal-paired", "--margin", "-1"], "a margin of 0 or more"),
        (["--design", "equal-groups", "--alpha", "0.5"], "a level between 0 and 1/2"),
        (["--target", "1"], "a power between 0 and 1"),
        (["--design", "paired", "--target", "1"], "a power between 0 and 1"),
        (["--design", "paired", "--alpha", "1"], "a level between 0 and 1"),
        (["--design", "equal-paired", "--participants", "1"], "one degree of freedom or more"),
        (["--design", "paired", "--participants", "1"], "two people or more"),
    ],
)
def test_options_that_make_no_sense_are_refused(
    arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["tools", "power", *arguments]) != 0
    assert said in capsys.readouterr().err


def test_least_effect_and_margin() -> None:
    """Equality within 0.5 and 1 SD, two groups of ten. statsmodels' sum of both tails is NaN from 5 SDs on."""
    assert [round(power_tost(x, 10, 10), 3) for x in (0.5, 1.0)] == [0.001, 0.391]
    assert round(least_for_power(lambda x: power_tost(x, 10, 10), 0.8), 2) == 1.36
    for n, effect in ((2, 11.54989), (14, 0.8101467)):
        least = least_for_power(lambda x, n=n: power_paired(x, n), 0.8)  # type: ignore[misc]
        assert least == pytest.approx(effect, rel=1e-6)
        assert power_paired(least, n) == pytest.approx(0.8, abs=1e-14)
    assert least_for_power(lambda x: power_paired(x, 14), 0.04) == 0.0
    assert power_paired(5.0, 14) == power_paired(-5.0, 14) == 1.0
