"""Rows "paper's test | companion | effect and interval", for one design or many."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats, Ints
from emg2vsa.companions.groups import EqualityTests, GroupTests, NormalityTests, PairTests
from emg2vsa.companions.table import BlockTests
from emg2vsa.report.outcome_text import Style, effect_said, p_said, range_said, span_said, statistic_said
from emg2vsa.report.table import Column, Table, records
from emg2vsa.report.wording import bounded, number
from emg2vsa.statistics.kruskal import smallest_worst_p
from emg2vsa.statistics.outcome import Outcome


def decided(outcomes: Sequence[Outcome], alpha: float, many: str, style: Style = "apa") -> str:
    """One test alone; of many, how many are significant and the range of their p. many : "specimens", "pairs"."""
    if len(outcomes) == 1:
        return statistic_said(outcomes[0], style)
    return how_many(np.array([outcome.p for outcome in outcomes], dtype=np.float64), alpha, many, style)


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

    def deviate(p: Floats) -> str:
        return how_many(p, alpha, many, style, "deviate")

    companions = [
        ("Lilliefors", deviate(tests.lilliefors.p), range_said("D", tests.lilliefors.statistic, style)),
        ("Shapiro-Wilk", deviate(tests.shapiro.p), range_said("W", tests.shapiro.statistic, style)),
    ]
    forms = ("standardised", tests.standardised.p), ("raw N(0, 1)", tests.raw.p)
    return [row for form, p in forms for row in rows_of(f"Kolmogorov-Smirnov, {form}: {deviate(p)}", companions)]


def group_rows(tests: GroupTests, alpha: float, many: str, style: Style = "apa") -> list[CompanionRow]:
    """One-way analysis of variance beside tests that rest on less. many : what each design is, "participants"."""
    all_of = range(tests.anova.f.size)
    paper = f"One-way ANOVA: {decided([tests.anova_outcome(i) for i in all_of], alpha, many, style)}"
    share = effect_said(tests.anova_outcome(), style) if len(all_of) == 1 else range_said("omega2", tests.omega2, style)
    ranks = range_said("rank epsilon2", tests.kruskal.epsilon2, style)
    welch, kruskal = (
        decided([of.outcome(i) for i in all_of], alpha, many, style) for of in (tests.welch, tests.kruskal)
    )
    bayes, means = range_said("BF01", tests.bayes.bf01, style), "above 3 supports equal means, below 1/3 different ones"
    companions = (
        ("Welch's ANOVA", welch, share),
        ("Kruskal-Wallis", kruskal, ranks),
        ("Bayes factor (JZS)", bayes, means),
    )
    return rows_of(paper, companions)


def variance_row(tests: GroupTests, alpha: float, many: str, style: Style = "apa") -> CompanionRow:
    """Not a test of the same hypothesis but of what the analysis of variance takes for granted."""
    found = [tests.brown_forsythe.outcome(i) for i in range(tests.anova.f.size)]
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.fmax.reduce(tests.sd, axis=1, initial=-np.inf) / np.fmin.reduce(tests.sd, axis=1, initial=np.inf)
    spread = range_said("largest SD / smallest SD", ratio[np.isfinite(ratio)], style)
    test = "Brown-Forsythe", decided(found, alpha, many, style), f"{spread}; where they are unequal, prefer Welch"
    return rows_of("One-way ANOVA assumes equal variances", [test])[0]


def pair_rows(tests: PairTests, alpha: float, style: Style = "apa") -> list[CompanionRow]:
    """Fisher's LSD beside tests that hold the error of the family; pooled mean ranks beside those of each pair."""

    def pairs(p: Floats) -> str:
        return how_many(p, alpha, "pairs", style)

    size = range_said("|g|", np.abs(tests.g), style)
    shift = range_said("|r_rb|", np.abs(tests.mann_whitney.rank_biserial), style)
    of_means = {
        "Holm": tests.p_holm, "Tukey's HSD": tests.tukey.p, "Games-Howell": tests.games_howell.p,
        "False discovery rate": tests.p_fdr,
    }  # fmt: skip
    ranks = "Mann-Whitney, exact with ties, Holm", pairs(tests.p_rank_holm), shift
    return [
        *rows_of(f"{tests.lsd.method}: {pairs(tests.lsd.p)}", [(name, pairs(p), size) for name, p in of_means.items()]),
        *rows_of(f"Dunn on mean ranks, Bonferroni (MATLAB's multcompare): {pairs(tests.dunn.p)}", [ranks]),
    ]


def over_people_pair_rows(
    tests: PairTests, blocks: BlockTests, alpha: float, style: Style = "apa"
) -> list[CompanionRow]:
    """Fisher's LSD beside the pairs over blocks, whose sample is the people."""
    paper = f"{tests.lsd.method}: {how_many(tests.lsd.p, alpha, 'pairs', style)}"
    size, people = range_said("|g_z|", np.abs(blocks.paired.g), style), f"over {blocks.repeated.n[0]} blocks, Holm"
    return rows_of(
        paper,
        [(f"{name} {people}", how_many(p, alpha, "pairs", style), size) for name, p in blocks.pair_families.items()],
    )


def over_people_rows(paper: str, blocks: BlockTests, style: Style = "apa") -> list[CompanionRow]:
    """``paper`` beside tests whose sample is the people: that which allows for unequal scatter first."""
    repeated, mixed = blocks.repeated, blocks.mixed
    epsilon = (
        f"sphericity ε: GG {bounded(float(repeated.epsilon_gg[0]), 2)}, HF {bounded(float(repeated.epsilon_hf[0]), 2)}"
    )
    tests = [(repeated.outcome(), epsilon), *([(mixed, "")] if mixed else []), (blocks.friedman.outcome(), "")]
    return rows_of(paper, (_over_people(found, more, style) for found, more in tests))


def _over_people(found: Outcome, more: str, style: Style) -> tuple[str, str, str]:
    failed = "; ".join(found.notes) if found.p is None or np.isnan(found.p) else ""
    effect = "; ".join(filter(None, (effect_said(found, style), more)))
    return f"{found.method[0].upper()}{found.method[1:]}", failed or statistic_said(found, style), effect


def equality_rows(
    paper: str, equality: EqualityTests, blocks: BlockTests | None, factor: float, unit: str, style: Style = "apa"
) -> list[CompanionRow]:
    """ "No difference found" beside what would show equality. factor, unit : for people, of the bound in the data."""
    level = f"{100 * (1 - 2 * equality.alpha):g}% intervals"
    bound, in_sd = (span_said(found, style) for found in (equality.bound * factor, equality.bound_sd))
    effect = f"{level} of all differences lie within ± {f'{bound} {unit}'.rstrip()} (± {in_sd} SD)"
    within, result = "", "no margin stated"
    if equality.margin:
        margin = f"{equality.margin:g} SD" if equality.unit == "sd" else f"{number(equality.margin * factor)} {unit}"
        within = f" within ± {margin}".rstrip()
        result = f"{int(np.sum(equality.shown))} of {int(np.sum(equality.pairs))} pairs shown equal"
    rows = rows_of(paper, [(f"Equivalence (TOST){within}", result, effect)])
    return [*rows, CompanionRow(paper, *_share(blocks, style))] if blocks else rows


def _share(blocks: BlockTests, style: Style) -> tuple[str, str]:
    """How much people differ, as a share of what is left unexplained."""
    mixed, agreement = blocks.mixed, blocks.agreement
    if mixed is not None and mixed.interval and not np.isnan(mixed.interval[0]):
        return "Variance components of the mixed model", effect_said(mixed, style)
    return f"Intraclass correlation of means, {agreement.estimate_name or ''}", effect_said(agreement, style)
