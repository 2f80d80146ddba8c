"""Rows "paper's test | companion | effect and interval", for one design or many."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats, Ints
from emg2vsa.companions.groups import EqualityTests, GroupTests, NormalityTests, PairTests
from emg2vsa.companions.table import BlockTests
from emg2vsa.figures.palette import ActivityScale
from emg2vsa.report.outcome_text import Style, effect_said, p_said, range_said, span_said, statistic_said
from emg2vsa.report.table import Column, Table, records
from emg2vsa.report.wording import bounded, number
from emg2vsa.statistics.anova import Anova
from emg2vsa.statistics.kruskal import KruskalWallis, smallest_worst_p
from emg2vsa.statistics.outcome import Outcomes


def decided(tests: Anova | KruskalWallis | Outcomes, alpha: float, many: str, style: Style = "apa") -> str:
    """One test alone; of many, how many are significant and the range of their p. many : "specimens", "blocks"."""
    return statistic_said(tests.outcome(0), style) if tests.p.size == 1 else how_many(tests.p, alpha, many, style)


def how_many(p: Floats, alpha: float, many: str, style: Style = "apa", does: str = "significant") -> str:
    """``14 of 14 participants significant (largest p < .001)``; ``does`` : another word for significant."""
    p = p[np.isfinite(p)]
    if not p.size:
        return "not defined"
    significant = int(np.count_nonzero(p < alpha))
    which, extreme = ("largest", p.max()) if 2 * significant > p.size else ("smallest", p.min())
    return f"{significant} of {p.size} {many} {does} ({which} {p_said(float(extreme), style)})"


def dunn_bounds(count: Ints) -> tuple[float, float] | None:
    """Smallest p of the worst pair, uncorrected and with Bonferroni, for groups of ``count`` (k,) untied values.

    None where the sizes differ: the bound is that of groups in a row without overlap, which only equal sizes make best.
    """
    sizes = np.unique(count)
    if sizes.size != 1 or sizes[0] < 1 or count.size < 2:
        return None
    return smallest_worst_p(count.size, int(sizes[0]))


COLUMNS = (Column("paper", "Paper's test"), Column("companion", "Companion"), Column("effect", "Effect and interval"))


@dataclass(frozen=True)
class CompanionRow:
    """One companion of one test of the paper, in words."""

    paper: str
    companion: str
    effect: str


def companion_table(
    name: str, of: str, rows: Sequence[CompanionRow], beside: str = "the paper's test beside its companions"
) -> Table:
    """``verdict_<name>``. People see a test of the paper once, above all its companions."""
    full = records(rows, COLUMNS)
    papers = ["", *(row.paper for row in rows)]
    shown = tuple(
        {**row, "paper": ""} if row["paper"] == above else row for row, above in zip(full, papers, strict=False)
    )
    return Table(f"verdict_{name}", f"{of}: {beside}", COLUMNS, full, shown)


def rows_of(paper: str, companions: Iterable[tuple[str, str, str]]) -> list[CompanionRow]:
    """Companions of one test: name, result and effect of each."""
    return [CompanionRow(paper, f"{name}: {result}", effect) for name, result, effect in companions]


def normality_rows(tests: NormalityTests, alpha: float, many: str, style: Style = "apa") -> list[CompanionRow]:
    """Both forms of Kolmogorov-Smirnov, each beside Lilliefors and Shapiro-Wilk. many : what each sample is."""

    def deviate(of: Outcomes) -> str:
        return how_many(of.p, alpha, many, style, "deviate")

    companions = [
        (name, deviate(of), range_said(of.statistic_name, of.statistic, style))
        for name, of in (("Lilliefors", tests.lilliefors), ("Shapiro-Wilk", tests.shapiro))
    ]
    forms = ("standardised", tests.standardised), ("raw N(0, 1)", tests.raw)
    return [row for form, of in forms for row in rows_of(f"Kolmogorov-Smirnov, {form}: {deviate(of)}", companions)]


def anova_said(tests: GroupTests, alpha: float, many: str, style: Style = "apa") -> str:
    """The paper's test of equal means. many : what each design is, "participants"."""
    return f"One-way ANOVA: {decided(tests.anova, alpha, many, style)}"


_BAYES = "above 3 supports equal means, below 1/3 different ones"


def group_rows(
    tests: GroupTests,
    alpha: float,
    many: str,
    style: Style = "apa",
    blocks: BlockTests | None = None,
    equal: Sequence[CompanionRow] = (),
) -> list[CompanionRow]:
    """One-way analysis of variance beside tests over people, tests that rest on less, ``equal``, and its assumption.

    many : as in ``anova_said``.
    """
    paper, one = anova_said(tests, alpha, many, style), tests.anova.p.size == 1
    share = effect_said(tests.anova_outcome(), style) if one else range_said("omega2", tests.omega2, style)
    ranks, bayes = (
        range_said(name, values, style)
        for name, values in (("rank epsilon2", tests.kruskal.epsilon2), ("BF01", tests.bayes.bf01))
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.fmax.reduce(tests.sd, axis=1, initial=-np.inf) / np.fmin.reduce(tests.sd, axis=1, initial=np.inf)
    spread = range_said("largest SD / smallest SD", ratio[np.isfinite(ratio)], style)
    welch, kruskal, variances = (
        decided(of, alpha, many, style) for of in (tests.welch, tests.kruskal, tests.brown_forsythe)
    )
    companions = (
        ("Welch's ANOVA", welch, share),
        ("Kruskal-Wallis", kruskal, ranks),
        ("Bayes factor (JZS)", bayes, _BAYES),
    )
    assumed = "Brown-Forsythe", variances, f"{spread}; where they are unequal, prefer Welch"
    over = rows_of(paper, _over_people(blocks, style)) if blocks else []
    return [
        *over, *rows_of(paper, companions), *equal, *rows_of("One-way ANOVA assumes equal variances", [assumed])
    ]  # fmt: skip


def _over_people(blocks: BlockTests, style: Style) -> Iterator[tuple[str, str, str]]:
    """That which allows for unequal scatter first."""
    repeated = blocks.repeated
    gg, hf = (bounded(float(epsilon[0]), 2) for epsilon in (repeated.epsilon_gg, repeated.epsilon_hf))
    every = (repeated.outcome(), f"sphericity ε: GG {gg}, HF {hf}"), (blocks.mixed, ""), (blocks.friedman.outcome(), "")
    for found, more in every:
        if found is not None:
            failed = "; ".join(found.notes) if found.p is None or np.isnan(found.p) else ""
            effect = "; ".join(filter(None, (effect_said(found, style), more)))
            yield f"{found.method[0].upper()}{found.method[1:]}", failed or statistic_said(found, style), effect


CORRECTED = {
    "holm": "Holm", "tukey": "Tukey", "games_howell": "Games-Howell", "fdr": "FDR", "dunn": "Dunn",
    "mann_whitney": "Mann-Whitney, Holm",
}  # fmt: skip
"""Tests of ``PairTests.corrected`` in heads of columns."""


def pair_rows(tests: PairTests, alpha: float, style: Style = "apa") -> list[CompanionRow]:
    """Fisher's LSD beside tests that hold the error of the family; pooled mean ranks beside those of each pair."""
    said = {name: how_many(p, alpha, "pairs", style) for name, p in tests.corrected.items()}
    size = range_said("|g|", np.abs(tests.g), style)
    shift = range_said("|r_rb|", np.abs(tests.mann_whitney.rank_biserial), style)
    of_means = {
        "Holm": "holm", "Tukey's HSD": "tukey", "Games-Howell": "games_howell", "False discovery rate": "fdr",
    }  # fmt: skip
    return [
        *rows_of(_lsd_said(tests, alpha, style), [(name, said[key], size) for name, key in of_means.items()]),
        *rows_of(
            f"Dunn on mean ranks, Bonferroni (MATLAB's multcompare): {said['dunn']}",
            [("Mann-Whitney, exact with ties, Holm", said["mann_whitney"], shift)],
        ),
    ]


def _lsd_said(tests: PairTests, alpha: float, style: Style) -> str:
    return f"{tests.lsd.method}: {how_many(tests.lsd.p, alpha, 'pairs', style)}"


def over_people_pair_rows(
    tests: PairTests, blocks: BlockTests, alpha: float, style: Style = "apa"
) -> list[CompanionRow]:
    """Fisher's LSD beside the pairs over blocks, whose sample is the people."""
    size, people = range_said("|g_z|", np.abs(blocks.paired.g), style), f"over {blocks.repeated.n[0]} blocks, Holm"
    return rows_of(
        _lsd_said(tests, alpha, style),
        [(f"{name} {people}", how_many(p, alpha, "pairs", style), size) for name, p in blocks.pair_families.items()],
    )


_AS_STORED = ActivityScale("", 1.0)


def equality_rows(
    paper: str,
    equality: EqualityTests,
    style: Style = "apa",
    blocks: BlockTests | None = None,
    scale: ActivityScale = _AS_STORED,
) -> list[CompanionRow]:
    """ "No difference found" beside what would show equality. scale : of the data, for people."""
    level = f"{100 * (1 - 2 * equality.alpha):g}% intervals"
    bound, in_sd = (span_said(found, style) for found in (equality.bound * scale.factor, equality.bound_sd))
    effect = f"{level} of all differences lie within ± {f'{bound} {scale.unit}'.rstrip()} (± {in_sd} SD)"
    within, result = "", "no margin stated"
    if equality.margin:
        margin = (
            f"{equality.margin:g} SD"
            if equality.unit == "sd"
            else f"{number(equality.margin * scale.factor)} {scale.unit}".rstrip()
        )
        within = f" within ± {margin}"
        result = f"{int(np.sum(equality.shown))} of {int(np.sum(equality.pairs))} pairs shown equal"
    rows = rows_of(paper, [(f"Equivalence (TOST){within}", result, effect)])
    if blocks is None:
        return rows
    # how much people differ, as a share of what is left unexplained
    mixed, agreement = blocks.mixed, blocks.agreement
    if mixed is not None and mixed.interval and not np.isnan(mixed.interval[0]):
        return [*rows, CompanionRow(paper, "Variance components of the mixed model", effect_said(mixed, style))]
    named = f"Intraclass correlation of means, {agreement.estimate_name or ''}"
    return [*rows, CompanionRow(paper, named, effect_said(agreement, style))]
