"""Results in four styles, as statistics manuals print them."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from emg2vsa.report.outcome_text import STYLES, effect_said, p_said, range_said, said
from emg2vsa.statistics.outcome import Outcome

ANOVA = Outcome(
    method="one-way ANOVA", n=50, statistic_name="F", statistic=5.231, df=(4.0, 45.0), p=0.0016,
    estimate_name="eta2", estimate=0.3174, interval=(0.081, 0.4603), confidence=0.95,
)  # fmt: skip
KRUSKAL = Outcome(
    method="Kruskal-Wallis", n=30, statistic_name="H", statistic=25.806, df=(2.0,), p=2.49e-6,
    effect_name="rank epsilon2", effect_size=0.8899,
)  # fmt: skip
KS = Outcome(method="KS", n=10, statistic_name="D", statistic=0.1623, p=0.9296)
RANKS = Outcome(
    method="Mann-Whitney", n=20, statistic_name="U", statistic=0.0, p=1.08e-5, effect_name="rank-biserial",
    effect_size=-1.0,
)  # fmt: skip
BAYES = Outcome(method="JZS", n=20, statistic_name="BF01", statistic=3.0784)
UNDEFINED = Outcome(method="x", n=2, statistic_name="F", statistic=math.nan, df=(1.0, 0.0), p=math.nan)


def plain(text: str) -> str:
    return text.replace("\N{NO-BREAK SPACE}", " ")


@pytest.mark.parametrize(
    ("outcome", "style", "shown"),
    [
        (ANOVA, "apa", "F(4, 45) = 5.23, p = .002, η² = .32, 95% CI [.08, .46]"),
        (ANOVA, "ieee", "F(4, 45) = 5.23, p = 0.002, η² = 0.32, 95 % CI [0.08, 0.46]"),
        (ANOVA, "latex", r"$F(4, 45) = 5.23$, $p = .002$, $\eta^2 = .32$, 95\,\% CI $[.08, .46]$"),
        (ANOVA, "plain", "F(4, 45) = 5.231, p = 0.0016, eta2 = 0.3174, 95 % CI [0.081, 0.4603]"),
        (KRUSKAL, "apa", "H(2) = 25.81, p < .001, ε²_R = .89"),
        (KRUSKAL, "ieee", "H(2) = 25.81, p < 0.001, ε²_R = 0.89"),
        (KRUSKAL, "plain", "H(2) = 25.806, p = 2.49e-06, rank epsilon2 = 0.8899"),
        (KS, "apa", "D(10) = 0.16, p = .930"),
        (RANKS, "apa", "U = 0.00, p < .001, r_rb = -1.00"),
        (BAYES, "apa", "BF₀₁ = 3.08"),
        (BAYES, "latex", r"$\mathrm{BF}_{01} = 3.08$"),
        (UNDEFINED, "apa", "not defined"),
    ],
)
def test_as_manuals_print_it(outcome: Outcome, style, shown: str) -> None:
    assert plain(said(outcome, style)) == shown


@pytest.mark.parametrize("style", STYLES)
def test_plain_is_ascii_and_mathematics_is_balanced(style) -> None:
    for outcome in (ANOVA, KRUSKAL, KS, RANKS, BAYES, UNDEFINED):
        text = said(outcome, style)
        assert text.isascii() or style in ("apa", "ieee")
        assert text.count("$") % 2 == 0
        assert ("$" in text) <= (style == "latex")


@pytest.mark.parametrize(("p", "shown"), [(0.0009999, "p < .001"), (0.9999, "p > .999"), (0.05, "p = .050")])
def test_p_at_its_ends(p: float, shown: str) -> None:
    assert plain(p_said(p)) == shown
    assert plain(p_said(p, "ieee")) == re.sub(r" \.", " 0.", shown)


def test_large_and_infinite_statistics_are_told() -> None:
    huge = Outcome(method="t", n=4, statistic_name="t", statistic=math.inf, df=(2.0,), p=0.0)
    assert plain(said(huge)) == "t(2) = ∞, p < .001"
    assert said(huge, "latex") == r"$t(2) = \infty$, $p < .001$"
    fractional = Outcome(method="Welch", n=9, statistic_name="F", statistic=2.5e7, df=(2.0, 5.4321), p=1e-9)
    assert plain(said(fractional)) == "F(2, 5.4) = 2.50e7, p < .001".replace("e7", "e+07")


def test_ranges_of_many_and_of_one() -> None:
    assert plain(range_said("eta2", np.array([0.12, np.nan, 0.61]))) == "η² from .12 to .61"
    assert plain(range_said("eta2", np.array([0.12]))) == "η² = .12"
    assert plain(range_said("eta2", np.array([0.121, 0.122]))) == "η² = .12"
    assert plain(range_said("eta2", np.array([np.nan]))) == "η² not defined"
    assert range_said("eta2", np.array([0.12, 0.61]), "latex") == r"$\eta^2$ from $.12$ to $.61$"


def test_the_effect_alone() -> None:
    assert plain(effect_said(ANOVA)) == "η² = .32, 95% CI [.08, .46]"
    assert effect_said(KS) == ""
