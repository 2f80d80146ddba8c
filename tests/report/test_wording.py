"""Numbers, intervals and results as people read them: in running text, and in four styles as manuals print them."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from emg2vsa.report.outcome_text import STYLES, effect_said, p_said, range_said, said
from emg2vsa.report.wording import aligned, bounded, count, interval, listed, number, p_text, percent, signed, typeset
from emg2vsa.statistics.outcome import Outcome

NAN = math.nan
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
UNDEFINED = Outcome(method="x", n=2, statistic_name="F", statistic=NAN, df=(1.0, 0.0), p=NAN)
HUGE = Outcome(method="t", n=4, statistic_name="t", statistic=math.inf, df=(2.0,), p=0.0)
FRACTIONAL = Outcome(method="Welch", n=9, statistic_name="F", statistic=2.5e7, df=(2.0, 5.4321), p=1e-9)


def plain(text: str) -> str:
    return text.replace("\N{NO-BREAK SPACE}", " ")


@pytest.mark.parametrize(
    ("made", "shown"),
    [
        # a p has three decimals and no leading zero
        (p_text(0.0391), "p = .039"), (p_text(0.0009999), "p < .001"), (p_text(0.001), "p = .001"),
        (p_text(1.0), "p > .999"), (p_text(0.9994), "p = .999"), (p_text(NAN), "p not defined"),
        (p_said(0.0009999), "p < .001"), (p_said(0.9999), "p > .999"), (p_said(0.05), "p = .050"),
        (p_said(0.0009999, "ieee"), "p < 0.001"), (p_said(0.9999, "ieee"), "p > 0.999"),
        (p_said(0.05, "ieee"), "p = 0.050"),
        # numbers keep their significant digits
        (number(23.0), "23.0"), (number(0.0), "0"), (number(7), "7"), (number(123456), "123456"),
        (number(123.4), "123"), (number(4321.6), "4322"), (number(0.05), "0.0500"), (number(7.2e-10), "7.20e-10"),
        (number(-0.474), "−0.474"),
        # what is not defined is never shown as a number
        (number(NAN), "–"), (number(None), "–"), (bounded(NAN), "–"), (percent(NAN), "–"), (signed(NAN), "–"),
        (bounded(-0.25, 2), "−.25"), (percent(0.4774), "47.7 %"), (signed(3.14), "+3.1"),
        (signed(-0.04, "%"), "+0.0 %"),
        (signed(-0.44, "%"), "−0.4 %"), (count(1, "trial"), "1 trial"), (count(2, "trial"), "2 trials"),
        (listed([]), ""), (listed(["S1"]), "S1"), (listed(["S1", "S3", "S5"]), "S1, S3 and S5"),
        # minus and percent are set in one way
        (typeset("95% CI [-0.1, -.3]"), "95 % CI [−0.1, −.3]"), (typeset("12 %"), "12 %"), (typeset("-3 dB"), "−3 dB"),
        (typeset("S-1"), "S-1"), (typeset("1e-05"), "1e-05"), (typeset("2026-11-23"), "2026-11-23"),
        (typeset("constant-min"), "constant-min"), (typeset("x (-1)"), "x (−1)"),
        # ranges of many and of one
        (range_said("eta2", np.array([0.12, NAN, 0.61])), "η² from .12 to .61"),
        (range_said("eta2", np.array([0.12])), "η² = .12"), (range_said("eta2", np.array([0.121, 0.122])), "η² = .12"),
        (range_said("eta2", np.array([NAN])), "η² not defined"),
        (range_said("eta2", np.array([0.12, 0.61]), "latex"), r"$\eta^2$ from $.12$ to $.61$"),
        (range_said("D", np.array([0.12, 0.61]), "latex"), r"$D$ from $0.120$ to $0.610$"),
        (effect_said(ANOVA), "η² = .32, 95% CI [.08, .46]"), (effect_said(KS), ""),
    ],
)  # fmt: skip
def test_small_words(made: str, shown: str) -> None:
    assert plain(made) == shown
    assert typeset(typeset(made)) == typeset(made)


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
        (HUGE, "apa", "t(2) = ∞, p < .001"),
        (HUGE, "latex", r"$t(2) = \infty$, $p < .001$"),
        (FRACTIONAL, "apa", "F(2, 5.4) = 2.50e+07, p < .001"),
    ],
)
def test_as_manuals_print_it(outcome: Outcome, style, shown: str) -> None:
    assert plain(said(outcome, style)) == shown


@pytest.mark.parametrize("style", STYLES)
def test_plain_is_ascii_and_mathematics_is_balanced(style) -> None:
    for outcome in (ANOVA, KRUSKAL, KS, RANKS, BAYES, UNDEFINED):
        text = said(outcome, style)
        assert text.isascii() or style in ("apa", "ieee")
        assert len(re.findall(r"\$", text)) % 2 == 0
        assert ("$" in text) <= (style == "latex")


@pytest.mark.parametrize(
    ("low", "high", "said"),
    [(1.7, 4.234, "3.01 [1.70, 4.23]"), (1.7, np.inf, "3.01 [1.70, ∞)"), (-np.inf, np.inf, "3.01 (−∞, ∞)"),
     (np.nan, np.nan, "3.01 [–, –]")],
)  # fmt: skip
def test_an_infinite_end_of_an_interval_is_open(low, high, said):
    assert interval(3.01, low, high) == said
    assert interval(np.nan, low, high) == "–"


def test_lines_are_as_wide_as_their_longest_cell() -> None:
    rows = [("pair", "p"), ("S1 - S10", ".039"), ("S1 - S2", "< .001")]
    assert list(aligned(rows)) == ["pair           p", "S1 - S10    .039", "S1 - S2   < .001"]
    assert list(aligned(rows, left=(0, 1))) == ["pair      p", "S1 - S10  .039", "S1 - S2   < .001"]
    assert list(aligned([])) == []
