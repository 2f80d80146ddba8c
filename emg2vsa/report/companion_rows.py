"""Rows "paper's test | companion | effect and interval | does the verdict change?", for one design or for many."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.companions.groups import GroupTests
from emg2vsa.companions.normality import NormalityTests
from emg2vsa.companions.pairs import PairTests
from emg2vsa.report.outcome_text import Style, effect_said, range_said
from emg2vsa.report.table import Column, Table
from emg2vsa.report.verdicts import change, change_of_evidence, decided, how_many
from emg2vsa.stats.outcome import Outcome

COLUMNS = (
    Column("paper", "Paper's test"),
    Column("companion", "Companion"),
    Column("effect", "Effect and interval"),
    Column("changes", "Does the verdict change?"),
)


@dataclass(frozen=True)
class Row:
    """One companion of one test of the paper, in words."""

    paper: str
    companion: str
    effect: str
    changes: str


def companion_table(name: str, caption: str, rows: Sequence[Row]) -> Table:
    """People see a test of the paper once, above all its companions."""
    papers = [""] + [row.paper for row in rows]
    full = tuple((row.paper, row.companion, row.effect, row.changes) for row in rows)
    shown = tuple(("" if row[0] == above else row[0], *row[1:]) for row, above in zip(full, papers, strict=False))
    return Table(name, caption, COLUMNS, full, shown)


def normality_rows(tests: NormalityTests, alpha: float, many: str, style: Style = "apa") -> list[Row]:
    """Both forms of Kolmogorov-Smirnov, each beside Lilliefors and Shapiro-Wilk. many : what each sample is."""
    companions = (
        ("Lilliefors", tests.lilliefors.p, range_said("D", tests.lilliefors.d, style)),
        ("Shapiro-Wilk", tests.shapiro.p, range_said("W", tests.shapiro.w, style)),
    )
    return [
        Row(
            f"Kolmogorov-Smirnov, {form}: {how_many(paper, alpha, many, style, 'deviate')}",
            f"{name}: {how_many(p, alpha, many, style, 'deviate')}",
            effect,
            change(paper, p, alpha),
        )
        for form, paper in (("standardised", tests.standardised.p), ("raw N(0, 1)", tests.raw.p))
        for name, p, effect in companions
    ]


def group_rows(tests: GroupTests, alpha: float, many: str, style: Style = "apa") -> list[Row]:
    """One-way analysis of variance beside tests that rest on less. many : what each design is, "participants"."""
    anova, all_of = tests.anova, range(tests.anova.f.size)
    paper = f"One-way ANOVA: {decided([tests.anova_outcome(i) for i in all_of], alpha, many, style)}"
    eta2 = effect_said(tests.anova_outcome(), style) if len(all_of) == 1 else range_said("eta2", anova.eta2, style)
    ranks = range_said("rank epsilon2", tests.kruskal.epsilon2, style)
    rows = [
        Row(paper, f"{name}: {decided(found, alpha, many, style)}", effect, change(anova.p, p, alpha))
        for name, found, p, effect in (
            ("Welch's ANOVA", [tests.welch.outcome(i) for i in all_of], tests.welch.p, eta2),
            ("Kruskal-Wallis", [tests.kruskal.outcome(i) for i in all_of], tests.kruskal.p, ranks),
        )
    ]
    return [*rows, _evidence_row(tests, paper, alpha, style)]


def _evidence_row(tests: GroupTests, paper: str, alpha: float, style: Style) -> Row:
    bf01 = tests.bayes.bf01
    return Row(
        paper,
        f"Bayes factor (JZS): {range_said('BF01', bf01, style)}",
        "above 3 supports equal means, below 1/3 different ones",
        change_of_evidence(tests.anova.p, bf01, alpha),
    )


def variance_row(tests: GroupTests, alpha: float, many: str, style: Style = "apa") -> Row:
    """Not a test of the same hypothesis but of what the analysis of variance takes for granted."""
    found = [tests.brown_forsythe.outcome(i) for i in range(tests.anova.f.size)]
    p = tests.brown_forsythe.anova.p
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.fmax.reduce(tests.sd, axis=1, initial=-np.inf) / np.fmin.reduce(tests.sd, axis=1, initial=np.inf)
    unequal = int(np.count_nonzero(p < alpha))
    says = "prefer Welch" if unequal else "no sign against it"
    return Row(
        "One-way ANOVA assumes equal variances",
        f"Brown-Forsythe: {decided(found, alpha, many, style)}",
        range_said("largest SD / smallest SD", ratio[np.isfinite(ratio)], style),
        says if len(found) == 1 or not unequal else f"{says} for {unequal} of {len(found)}",
    )


def pair_rows(tests: PairTests, alpha: float, style: Style = "apa") -> list[Row]:
    """Fisher's LSD beside tests that hold the error of the family; pooled mean ranks beside those of each pair."""
    size = range_said("|g|", np.abs(tests.g), style)
    shift = range_said("|r_rb|", np.abs(tests.mann_whitney.rank_biserial), style)
    families: tuple[tuple[str, Floats, str, str, Floats], ...] = (
        ("Holm", tests.p_holm, size, tests.lsd.method, tests.lsd.p),
        ("Tukey's HSD", tests.tukey.p, size, tests.lsd.method, tests.lsd.p),
        ("Games-Howell", tests.games_howell.p, size, tests.lsd.method, tests.lsd.p),
        ("False discovery rate", tests.p_fdr, size, tests.lsd.method, tests.lsd.p),
        (
            "Mann-Whitney, exact with ties, Holm", tests.p_rank_holm, shift,
            "Dunn on mean ranks, Bonferroni (MATLAB's multcompare)", tests.dunn.p,
        ),
    )  # fmt: skip
    return [
        Row(
            f"{method}: {how_many(paper, alpha, 'pairs', style)}",
            f"{name}: {how_many(p, alpha, 'pairs', style)}",
            effect,
            change(paper, p, alpha),
        )
        for name, p, effect, method, paper in families
    ]


def p_of(outcome: Outcome) -> float:
    """NaN where the outcome has none."""
    return float("nan") if outcome.p is None else outcome.p
