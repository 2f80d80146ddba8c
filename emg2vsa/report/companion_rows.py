"""Rows "paper's test | companion | effect and interval | does the verdict change?", for one design or many."""

from __future__ import annotations

from collections.abc import Sequence
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

NO = "no"
UNDECIDED = "cannot be said"


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


def change(paper: Floats, companion: Floats, alpha: float) -> str:
    """Whether test by test the companion decides as the paper's test does; p of both, of the same shape."""
    both = np.isfinite(paper) & np.isfinite(companion)
    n = int(np.count_nonzero(both))
    if n == 0:
        return UNDECIDED
    lost = int(np.count_nonzero(both & (paper < alpha) & (companion >= alpha)))
    gained = int(np.count_nonzero(both & (paper >= alpha) & (companion < alpha)))
    if lost + gained == 0:
        return NO
    if n == 1:
        return "yes: no longer significant" if lost else "yes: significant"
    parts = [f"{lost} no longer significant"] * bool(lost) + [f"{gained} newly significant"] * bool(gained)
    return f"yes, for {lost + gained} of {n}: {', '.join(parts)}"


def change_of_claim(paper: Floats, companion: float, alpha: float) -> str:
    """The same for one companion of a whole family: do all of the family, or none, decide as it does?"""
    paper = paper[np.isfinite(paper)]
    if not paper.size or np.isnan(companion):
        return UNDECIDED
    share = float(np.mean(paper < alpha))
    if share in (0.0, 1.0):
        return (
            NO
            if (share == 1.0) == (companion < alpha)
            else "yes: " + ("significant" if companion < alpha else "not significant")
        )
    says = "significant" if companion < alpha else "not significant"
    return f"the paper's tests disagree ({np.count_nonzero(paper < alpha)} of {paper.size} significant); here {says}"


def change_of_evidence(paper: Floats, bf01: Floats, alpha: float) -> str:
    """Whether a Bayes factor BF01 backs the decisions: above 3 for "equal", below 1/3 for "different"."""
    both = np.isfinite(paper) & ~np.isnan(bf01)
    n = int(np.count_nonzero(both))
    if n == 0:
        return UNDECIDED
    significant = paper < alpha
    against = both & np.where(significant, bf01 > 3, bf01 < 1 / 3)
    weak = both & (bf01 >= 1 / 3) & (bf01 <= 3)
    parts = [
        f"{what}{f' for {number}' if n > 1 else ''}"
        for what, number in (("contradicted", int(np.sum(against))), ("no evidence either way", int(np.sum(weak))))
        if number
    ]
    return NO if not parts else f"{', '.join(parts)}{f' of {n}' if n > 1 else ''}"


def dunn_bounds(count: Ints) -> tuple[float, float] | None:
    """Smallest p of the worst pair, uncorrected and with Bonferroni, for groups of ``count`` (k,) untied values.

    None where the sizes differ: the bound is that of groups in a row without overlap, which only equal sizes make best.
    """
    sizes = np.unique(count)
    if sizes.size != 1 or sizes[0] < 1 or count.size < 2:
        return None
    return smallest_worst_p(count.size, int(sizes[0]))


COLUMNS = (
    Column("paper", "Paper's test"),
    Column("companion", "Companion"),
    Column("effect", "Effect and interval"),
    Column("changes", "Does the verdict change?"),
)


@dataclass(frozen=True)
class CompanionRow:
    """One companion of one test of the paper, in words."""

    paper: str
    companion: str
    effect: str
    changes: str


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


def normality_rows(tests: NormalityTests, alpha: float, many: str, style: Style = "apa") -> list[CompanionRow]:
    """Both forms of Kolmogorov-Smirnov, each beside Lilliefors and Shapiro-Wilk. many : what each sample is."""
    companions = (
        ("Lilliefors", tests.lilliefors.p, range_said("D", tests.lilliefors.statistic, style)),
        ("Shapiro-Wilk", tests.shapiro.p, range_said("W", tests.shapiro.statistic, style)),
    )
    return [
        CompanionRow(
            f"Kolmogorov-Smirnov, {form}: {how_many(paper, alpha, many, style, 'deviate')}",
            f"{name}: {how_many(p, alpha, many, style, 'deviate')}",
            effect,
            change(paper, p, alpha),
        )
        for form, paper in (("standardised", tests.standardised.p), ("raw N(0, 1)", tests.raw.p))
        for name, p, effect in companions
    ]


def group_rows(tests: GroupTests, alpha: float, many: str, style: Style = "apa") -> list[CompanionRow]:
    """One-way analysis of variance beside tests that rest on less. many : what each design is, "participants"."""
    anova, all_of = tests.anova, range(tests.anova.f.size)
    paper = f"One-way ANOVA: {decided([tests.anova_outcome(i) for i in all_of], alpha, many, style)}"
    eta2 = effect_said(tests.anova_outcome(), style) if len(all_of) == 1 else range_said("eta2", anova.eta2, style)
    ranks = range_said("rank epsilon2", tests.kruskal.epsilon2, style)
    rows = [
        CompanionRow(paper, f"{name}: {decided(found, alpha, many, style)}", effect, change(anova.p, p, alpha))
        for name, found, p, effect in (
            ("Welch's ANOVA", [tests.welch.outcome(i) for i in all_of], tests.welch.p, eta2),
            ("Kruskal-Wallis", [tests.kruskal.outcome(i) for i in all_of], tests.kruskal.p, ranks),
        )
    ]
    return [*rows, evidence_row(paper, anova.p, tests.bayes.bf01, alpha, style)]


def welch_row(tests: GroupTests, alpha: float, many: str) -> CompanionRow:
    """Welch's ANOVA beside Kruskal and Wallis's."""
    ranks = tests.kruskal.p
    return CompanionRow(
        f"Kruskal-Wallis: {how_many(ranks, alpha, many)}",
        f"Welch's ANOVA: {how_many(tests.welch.p, alpha, many)}",
        range_said("rank epsilon2", tests.kruskal.epsilon2),
        change(ranks, tests.welch.p, alpha),
    )


def evidence_row(paper: str, p: Floats, bf01: Floats, alpha: float, style: Style = "apa") -> CompanionRow:
    """Bayes factors beside the p of ``paper``."""
    return CompanionRow(
        paper,
        f"Bayes factor (JZS): {range_said('BF01', bf01, style)}",
        "above 3 supports equal means, below 1/3 different ones",
        change_of_evidence(p, bf01, alpha),
    )


def variance_row(tests: GroupTests, alpha: float, many: str, style: Style = "apa") -> CompanionRow:
    """Not a test of the same hypothesis but of what the analysis of variance takes for granted."""
    found = [tests.brown_forsythe.outcome(i) for i in range(tests.anova.f.size)]
    p = tests.brown_forsythe.p
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.fmax.reduce(tests.sd, axis=1, initial=-np.inf) / np.fmin.reduce(tests.sd, axis=1, initial=np.inf)
    unequal = int(np.count_nonzero(p < alpha))
    says = "prefer Welch" if unequal else "no sign against it"
    return CompanionRow(
        "One-way ANOVA assumes equal variances",
        f"Brown-Forsythe: {decided(found, alpha, many, style)}",
        range_said("largest SD / smallest SD", ratio[np.isfinite(ratio)], style),
        says if len(found) == 1 or not unequal else f"{says} for {unequal} of {len(found)}",
    )


def pair_rows(tests: PairTests, alpha: float, style: Style = "apa") -> list[CompanionRow]:
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
        CompanionRow(
            f"{method}: {how_many(paper, alpha, 'pairs', style)}",
            f"{name}: {how_many(p, alpha, 'pairs', style)}",
            effect,
            change(paper, p, alpha),
        )
        for name, p, effect, method, paper in families
    ]


def over_people_pair_rows(
    tests: PairTests, blocks: BlockTests, alpha: float, style: Style = "apa"
) -> list[CompanionRow]:
    """Fisher's LSD beside the pairs over blocks, whose sample is the people; pair by pair where both have the same."""
    paper = f"{tests.lsd.method}: {how_many(tests.lsd.p, alpha, 'pairs', style)}"
    size = range_said("|g_z|", np.abs(blocks.paired.g), style)
    return [
        CompanionRow(
            paper,
            f"{name} over {blocks.repeated.n[0]} blocks, Holm: {how_many(p, alpha, 'pairs', style)}",
            size,
            change(tests.lsd.p, p, alpha)
            if p.shape == tests.lsd.p.shape
            else change_of_claim(tests.lsd.p, float(np.max(p)), alpha),
        )
        for name, p in blocks.pair_families.items()
    ]


def p_of(outcome: Outcome) -> float:
    """NaN where the outcome has none."""
    return float("nan") if outcome.p is None else outcome.p


def over_people_rows(
    paper: str, paper_p: Floats, blocks: BlockTests, alpha: float, style: Style = "apa"
) -> list[CompanionRow]:
    """``paper`` (its p in ``paper_p``) beside tests whose sample is the people."""
    repeated = blocks.repeated
    epsilon = (
        f"sphericity ε: GG {bounded(float(repeated.epsilon_gg[0]), 2)}, HF {bounded(float(repeated.epsilon_hf[0]), 2)}"
    )
    corrected, ranks = repeated.outcome(), blocks.friedman.outcome()
    return [
        *([_over_people(paper, paper_p, blocks.mixed, "", alpha, style)] if blocks.mixed else []),
        _over_people(paper, paper_p, corrected, epsilon, alpha, style),
        _over_people(paper, paper_p, ranks, "", alpha, style),
    ]


def _over_people(paper: str, paper_p: Floats, found: Outcome, more: str, alpha: float, style: Style) -> CompanionRow:
    failed = "; ".join(found.notes) if np.isnan(p_of(found)) else ""
    return CompanionRow(
        paper,
        f"{found.method[0].upper()}{found.method[1:]}: {failed or statistic_said(found, style)}",
        "; ".join(filter(None, (effect_said(found, style), more))),
        change_of_claim(paper_p, p_of(found), alpha),
    )


def equality_rows(
    paper: str, equality: EqualityTests, blocks: BlockTests | None, factor: float, unit: str, style: Style = "apa"
) -> list[CompanionRow]:
    """ "No difference found" beside what would show equality. factor, unit : for people, of the bound in the data."""
    return [_margin_row(paper, equality, factor, unit, style), *([_share_row(paper, blocks, style)] if blocks else [])]


def _margin_row(paper: str, equality: EqualityTests, factor: float, unit: str, style: Style) -> CompanionRow:
    level = f"{100 * (1 - 2 * equality.alpha):g}% intervals"
    bound, in_sd = (span_said(found, style) for found in (equality.bound * factor, equality.bound_sd))
    effect = f"{level} of all differences lie within ± {f'{bound} {unit}'.rstrip()} (± {in_sd} SD)"
    if not equality.margin:
        return CompanionRow(paper, "Equivalence (TOST): no margin stated", effect, UNDECIDED + " without a margin")
    shown, pairs = int(np.sum(equality.shown)), int(np.sum(equality.pairs))
    margin = f"± {equality.margin:g} SD" if equality.unit == "sd" else f"± {number(equality.margin * factor)} {unit}"
    return CompanionRow(
        paper,
        f"Equivalence (TOST) within {margin.rstrip()}: {shown} of {pairs} pairs shown equal",
        effect,
        "no" if shown == pairs else f"yes: equality not shown for {pairs - shown} of {pairs} pairs",
    )


def _share_row(paper: str, blocks: BlockTests, style: Style) -> CompanionRow:
    """How much people differ, as a share of what is left unexplained."""
    mixed = blocks.mixed
    low = mixed.interval[0] if mixed and mixed.interval else float("nan")
    if mixed is None or np.isnan(low):
        found = blocks.agreement
        low = found.interval[0] if found.interval else float("nan")
        name = "Intraclass correlation of means, " + (found.estimate_name or "")
    else:
        found, name = mixed, "Variance components of the mixed model"
    verdict = UNDECIDED if np.isnan(low) else "yes: people differ" if low > 0 else "no: the interval reaches 0"
    return CompanionRow(paper, name, effect_said(found, style), verdict)
