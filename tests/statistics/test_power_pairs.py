"""Power of paired t tests and of equality: statsmodels, simulation, and published sample sizes."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy import stats

from emg2vsa.cli import main
from emg2vsa.errors import SettingError
from emg2vsa.statistics.power import fewest_people
from emg2vsa.statistics.power_pairs import effect_for_power, power_paired, power_tost


@pytest.mark.parametrize(("n", "effect", "alpha"), [(14, 0.5, 0.05), (5, 0.2, 0.01), (40, -0.3, 0.05), (3, 0.0, 0.2)])
def test_paired_is_statsmodels(n: int, effect: float, alpha: float) -> None:
    peer = pytest.importorskip("statsmodels.stats.power").TTestPower()
    assert power_paired(effect, n, alpha) == pytest.approx(peer.power(effect, n, alpha), abs=1e-13)


def test_paired_by_simulation() -> None:
    y = 0.6 + np.random.default_rng(1).standard_normal((20_000, 12))
    assert np.mean(stats.ttest_1samp(y, 0, axis=1).pvalue < 0.05) == pytest.approx(
        float(power_paired(0.6, 12)), abs=0.01
    )


def test_gpowers_paired_example() -> None:
    """G*Power, "means: difference between two dependent means": d_z = .5, alpha .05, power .8 need 34 people."""
    assert fewest_people(lambda n: power_paired(0.5, n), 0.8) == 34
    assert power_paired(0.5, 34) == pytest.approx(0.8077775, abs=1e-6)
    assert power_paired(effect_for_power(0.8, 14), 14) == pytest.approx(0.8, abs=1e-12)


@pytest.mark.parametrize(("cv", "n", "power"), [(0.3, 40, 0.815845), (0.2, 20, 0.834680)])
def test_published_powers_of_bioequivalence(cv: float, n: int, power: float) -> None:
    """PowerTOST's documentation: 2 x 2 crossover, limits .80 to 1.25, true ratio .95."""
    group_sd = np.sqrt(np.log(1 + cv**2) / 2)
    found = power_tost(np.log(1.25) / group_sd, n // 2, n // 2, np.log(0.95) / group_sd)
    assert found == pytest.approx(power, abs=5e-7)


@pytest.mark.parametrize("arguments", [{"effect_dz": np.inf}, {"alpha": 1.0}, {"n": 1}, {"n": np.nan}])
def test_numbers_that_make_no_sense_are_refused(arguments: dict[str, float]) -> None:
    with pytest.raises(SettingError, match="paired power"):
        power_paired(**{"effect_dz": 0.5, "n": 10, "alpha": 0.05} | arguments)


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
        (["--design", "paired", "--target", "1"], "a power between 0 and 1"),
        (["--design", "paired", "--participants", "1"], "two people or more"),
    ],
)
def test_options_that_make_no_sense_are_refused(
    arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["tools", "power", *arguments]) != 0
    assert said in capsys.readouterr().err
