"""Rows "paper's test | companion | effect and interval | does the verdict change?" for one table or many designs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.companions.blocks import BlockTests
from emg2vsa.companions.clusters_normal import NormalityTests
from emg2vsa.companions.groups import GroupTests
from emg2vsa.companions.pairs import PairTests
from emg2vsa.report.outcome_text import Style, effect_said, said
from emg2vsa.report.verdicts import (
    change,
    change_of_claim,
    change_of_evidence,
    decided,
    how_many,
)
from emg2vsa.report.wording import UNDEFINED, bounded, number
from emg2vsa.stats.dunn import smallest_worst_p
from emg2vsa.stats.equivalence import Equivalence
from emg2vsa.stats.outcome import Outcome

HEADS = ("Paper's test", "Companion", "Effect and interval", "Does the verdict change?")


@dataclass(frozen=True)
class Row:
    """One companion of one test of the paper, in words."""

    paper: str
    companion: str
    effect: str
    changes: str


def normality_rows(tests: NormalityTests, alpha: float, many: str, style: Style) -> list[Row]:
    """Standardised and raw Kolmogorov-Smirnov, each beside Lilliefors and Shapiro-Wilk. many : "clusters"."""
    rows = []
    for name, paper in (("standardised", tests.standardised.p), ("raw", tests.raw.p)):
        for companion, of, effect in (
            ("Lilliefors", tests.lilliefors.p, _range("D", tests.lilliefors.d, 2)),
            ("Shapiro-Wilk", tests.shapiro.p, _range("W", tests.shapiro.w, 2)),
        ):
            rows.append(
                Row(
                    f"Kolmogorov-Smirnov, {name}: {how_many(paper, alpha, many, style)}",
                    f"{companion}: {how_many(of, alpha, many, style)}",
                    effect,
                    change(paper, of, alpha),
                )
            )
    return rows


def group_rows(tests: GroupTests, alpha: float, many: str, style: Style) -> list[Row]:
    """One-way analysis of variance beside what shares fewer of its assumptions. many : designs, "participants"."""
    designs = range(tests.anova.f.size)
    anova = [tests.anova_outcome(i) for i in designs]
    paper = f"one-way ANOVA: {decided(anova, alpha, many, style)}"
    single = len(anova) == 1
    eta2 = effect_said(anova[0], style) if single else _range("η²", tests.anova.eta2, 2)
    spread = np.nanmax(tests.sd, axis=1) / np.nanmin(tests.sd, axis=1) if tests.sd.size else np.empty(0)
    bf01 = tests.bayes.bf01

    def row(name: str, found: Sequence[Outcome], p: Floats, effect: str) -> Row:
        return Row(paper, f"{name}: {decided(found, alpha, many, style)}", effect, change(tests.anova.p, p, alpha))

    return [
        row("Welch's ANOVA, variances may differ", [tests.welch.outcome(i) for i in designs], tests.welch.p, eta2),
        row(
            "Kruskal-Wallis, on ranks",
            [tests.kruskal.outcome(i) for i in designs],
            tests.kruskal.p,
            _range("ε²_R", tests.kruskal.epsilon2, 2),
        ),
        Row(
            paper,
            "Brown-Forsythe, are variances equal: "
            + decided([tests.brown_forsythe.outcome(i) for i in designs], alpha, many, style),
            _range("largest SD / smallest SD", spread, 3),
            "concerns the assumption",
        ),
        Row(
            paper,
            "Bayes factor BF₀₁, for equality: " + _range("", bf01, 3).strip(" ="),
            "above 3 speaks for equal, below 1/3 for different means",
            change_of_evidence(tests.anova.p, bf01, alpha),
        ),
    ]


def pair_rows(tests: PairTests, alpha: float, many: str, style: Style) -> list[Row]:
    """Fisher's LSD beside the tests that hold the error of a family; mean ranks beside exact ranks of the pair."""
    lsd, ranks = tests.lsd, tests.dunn
    effect = _range("|g|", np.abs(tests.g), 3)
    shift = _range("|r_rb|", np.abs(tests.mann_whitney.rank_biserial), 2)
    paper = f"{lsd.method}, not corrected: {how_many(lsd.p, alpha, many, style)}"
    on_ranks = f"Dunn on pooled mean ranks, Bonferroni: {how_many(ranks.p, alpha, many, style)}"
    rows = [
        Row(paper, f"{name}: {how_many(p, alpha, many, style)}", effect, change(lsd.p, p, alpha))
        for name, p in (
            ("Holm", tests.p_holm),
            ("Tukey's HSD", tests.tukey.p),
            ("Games-Howell, variances may differ", tests.games_howell.p),
            ("false discovery rate", tests.p_fdr),
        )
    ]
    p = tests.p_rank_holm
    exact = f"Mann-Whitney, exact with ties, Holm: {how_many(p, alpha, many, style)}"
    return [*rows, Row(on_ranks, exact, shift, change(ranks.p, p, alpha))]


def block_rows(
    paper_p: Floats, paper: str, blocks: BlockTests, alpha: float, style: Style, people: str
) -> list[Row]:
    """Analyses that take repetitions of one of the ``people`` as independent, beside those over people."""
    repeated = blocks.repeated
    rows = [
        Row(
            paper,
            f"{outcome.method} on means: {said(outcome, style)}",
            f"ε_GG = {bounded(float(repeated.epsilon_gg[0]), 2)}, ε_HF = {bounded(float(repeated.epsilon_hf[0]), 2)}"
            if outcome.statistic_name == "F"
            else UNDEFINED,
            change_of_claim(paper_p, float("nan") if outcome.p is None else outcome.p, alpha),
        )
        for outcome in (repeated.outcome(), blocks.friedman.outcome())
    ]
    if (mixed := blocks.mixed) is not None:
        rows.insert(
            0,
            Row(
                paper,
                f"{mixed.method}: {said(_test_alone(mixed), style)}",
                effect_said(mixed, style) or UNDEFINED,
                change_of_claim(paper_p, float("nan") if mixed.p is None else mixed.p, alpha),
            ),
        )
    return rows


def equality_rows(paper_p: Floats, paper: str, tests: GroupTests, tost: Equivalence | None, alpha: float) -> list[Row]:
    """"No difference found" beside tests that can show equality."""
    return []


def _test_alone(outcome: Outcome) -> Outcome:
    from dataclasses import replace
    return replace(outcome, effect_name=None, estimate_name=None)


def _range(name: str, values: Floats, digits: int) -> str:
    """``η² = .32``, ``η² from .12 to .61``."""
    return ""
