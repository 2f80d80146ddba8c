"""Rows "paper's test | companion | effect and interval", for one design or many."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from emg2vsa.arrays import Floats, Ints
from emg2vsa.companions.groups import EqualityTests, GroupTests, NormalityTests, PairTests
from emg2vsa.companions.table import BlockTests
from emg2vsa.figures.palette import ActivityScale as Scale
from emg2vsa.report.outcome_text import Style, effect_said, p_said, range_said, span_said, statistic_said
from emg2vsa.report.table import Column, Table, records
from emg2vsa.report.wording import activity, bounded
from emg2vsa.statistics.anova import Anova
from emg2vsa.statistics.clusters import Names
from emg2vsa.statistics.kruskal import KruskalWallis, smallest_worst_p
from emg2vsa.statistics.outcome import Outcomes
from emg2vsa.statistics.post_hoc import PairDifferences


def decided(tests: Anova | KruskalWallis | Outcomes, alpha: float, many: str, style: Style = "apa") -> str:
    """One test alone; of many, how many are significant and the range of their p. many : "specimens", "blocks"."""
    return statistic_said(tests.outcome(0), style) if tests.p.size == 1 else how_many(tests.p, alpha, many, style)


def how_many(p: Floats, alpha: float, many: str, style: Style = "apa", does: str = "significant") -> str:
    """``14 of 14 participants significant (largest p < .001)`` of p (n,); ``does`` : another word for significant."""
    p = p[np.isfinite(p)]
    if not p.size:
        return "not defined"
    significant = int(np.count_nonzero(p < alpha))
    which, extreme = ("the others from", p[p >= alpha]) if 2 * significant > p.size else ("smallest", p)
    which, extreme = (which, extreme.min()) if significant < p.size else ("largest", p.max())
    return f"{significant} of {p.size} {many} {does} ({which} {p_said(float(extreme), style)})"


def dunn_bounds(count: Ints) -> tuple[float, float] | None:
    """Smallest p of the worst pair, uncorrected and with Bonferroni, for groups of ``count`` (k,) untied values.

    None where the sizes differ: the bound is that of groups in a row without overlap, which only equal sizes make best.
    """
    alike = count.size > 1 and count[0] > 0 and np.all(count == count[0])
    return smallest_worst_p(count.size, int(count[0])) if alike else None


COLUMNS = (Column("paper", "Paper's test"), Column("companion", "Companion"), Column("effect", "Effect and interval"))


@dataclass(frozen=True)
class CompanionRow:
    """One companion of one test of the paper, in words."""

    paper: str
    companion: str
    effect: str


Rows = Sequence[CompanionRow]


def once(texts: Iterable[str]) -> list[str]:
    """Each text where it differs from the one above, else ""."""
    return [text if text != above else "" for above, text in pairwise(["", *texts])]


def companion_table(name: str, of: str, rows: Rows, beside: str = "the paper's test beside its companions") -> Table:
    """``verdict_<name>``. People see a test of the paper once, above all its companions."""
    shown = [replace(row, paper=paper) for row, paper in zip(rows, once(row.paper for row in rows), strict=True)]
    return Table(f"verdict_{name}", f"{of}: {beside}", COLUMNS, records(rows, COLUMNS), records(shown, COLUMNS))


def rows_of(paper: str, companions: Iterable[tuple[str, str, str]]) -> Rows:
    """Companions of one test: name, result and effect of each."""
    return [CompanionRow(paper, f"{name}: {result}", effect) for name, result, effect in companions]


def normality_rows(tests: NormalityTests, alpha: float, many: str, style: Style = "apa") -> Rows:
    """Both forms of Kolmogorov-Smirnov, each beside Lilliefors and Shapiro-Wilk. many : what each sample is."""
    forms = {"standardised": tests.standardised, "raw N(0, 1)": tests.raw}
    by = {"Lilliefors": tests.lilliefors, "Shapiro-Wilk": tests.shapiro}
    deviate = {name: how_many(of.p, alpha, many, style, "deviate") for name, of in (forms | by).items()}
    companions = [(name, deviate[name], range_said(of.statistic_name, of.statistic, style)) for name, of in by.items()]
    return [row for form in forms for row in rows_of(f"Kolmogorov-Smirnov, {form}: {deviate[form]}", companions)]


def anova_said(tests: GroupTests, alpha: float, many: str, style: Style = "apa") -> str:
    """The paper's test of equal means. many : what each design is, "participants"."""
    return f"One-way ANOVA: {decided(tests.anova, alpha, many, style)}"


def group_rows(
    tests: GroupTests, alpha: float, many: str, style: Style = "apa", over: BlockTests | None = None, equal: Rows = ()
) -> Rows:
    """One-way analysis of variance beside tests over people, tests that rest on less, ``equal``, and its assumption."""
    paper, one = anova_said(tests, alpha, many, style), tests.anova.p.size == 1
    share = effect_said(tests.anova_outcome(), style) if one else range_said("omega2", tests.omega2, style)
    ranks = range_said("rank epsilon2", tests.kruskal.epsilon2, style)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.fmax.reduce(tests.sd, axis=1, initial=-np.inf) / np.fmin.reduce(tests.sd, axis=1, initial=np.inf)
    spread = range_said("largest SD / smallest SD", ratio[np.isfinite(ratio)], style)
    welch, kruskal, variances = (
        decided(of, alpha, many, style) for of in (tests.welch, tests.kruskal, tests.brown_forsythe)
    )
    bayes = range_said("BF01", tests.bayes.bf01, style), "above 3 supports equal means, below 1/3 different ones"
    return [
        *rows_of(paper, _over_people(over, style) if over else ()),
        *rows_of(paper, [("Welch's ANOVA", welch, share), ("Kruskal-Wallis", kruskal, ranks)]),
        *rows_of(paper, [("Bayes factor (JZS)", *bayes)]),
        *equal,
        CompanionRow(
            "One-way ANOVA assumes equal variances", f"Brown-Forsythe: {variances}",
            f"{spread}; where they are unequal, prefer Welch",
        ),
    ]  # fmt: skip


def _over_people(blocks: BlockTests, style: Style) -> Iterator[tuple[str, str, str]]:
    """Tests over people, first the one that allows for unequal scatter."""
    gg, hf = (bounded(float(e[0]), 2) for e in (blocks.repeated.epsilon_gg, blocks.repeated.epsilon_hf))
    sphericity = f"sphericity ε: GG {gg}, HF {hf}"
    for found, more in (blocks.repeated.outcome(), sphericity), (blocks.mixed, ""), (blocks.friedman.outcome(), ""):
        if found is not None:
            failed = "; ".join(found.notes) if found.p is None or np.isnan(found.p) else ""
            effect = "; ".join(filter(None, (effect_said(found, style), more)))
            yield f"{found.method[0].upper()}{found.method[1:]}", failed or statistic_said(found, style), effect


CORRECTED = {
    "holm": "Holm", "tukey": "Tukey", "games_howell": "Games-Howell", "fdr": "FDR", "dunn": "Dunn",
    "mann_whitney": "Mann-Whitney, Holm",
}  # fmt: skip
"""Tests of ``PairTests.corrected`` in heads of columns."""


def pair_names(names: Names, pairs: PairDifferences, between: str = " - ") -> list[str]:
    """``S1 - S3`` of every pair."""
    return [f"{names[i]}{between}{names[j]}" for i, j in zip(pairs.first, pairs.second, strict=True)]


def pair_rows(tests: PairTests, alpha: float, style: Style = "apa", over: BlockTests | None = None) -> Rows:
    """Fisher's LSD beside tests that hold the error of the family; pooled mean ranks beside those of each pair.

    over : beside the pairs over these blocks, whose sample is the people.
    """

    def pairs(p: Floats) -> str:
        return how_many(p, alpha, "pairs", style)

    lsd, p = f"{tests.lsd.method}: {pairs(tests.lsd.p)}", tests.corrected
    if over is not None:
        size, people = range_said("|g_z|", np.abs(over.paired.g), style), f"over {over.repeated.n[0]} blocks, Holm"
        return rows_of(lsd, [(f"{name} {people}", pairs(of), size) for name, of in over.pair_families.items()])
    size = range_said("|g|", np.abs(tests.g), style)
    shift = range_said("|r_rb|", np.abs(tests.mann_whitney.rank_biserial), style)
    of_means = {"Holm": "holm", "Tukey's HSD": "tukey", "Games-Howell": "games_howell", "False discovery rate": "fdr"}
    dunn = f"Dunn on mean ranks, Bonferroni (MATLAB's multcompare): {pairs(p['dunn'])}"
    return [
        *rows_of(lsd, [(name, pairs(p[key]), size) for name, key in of_means.items()]),
        *rows_of(dunn, [("Mann-Whitney, exact with ties, Holm", pairs(p["mann_whitney"]), shift)]),
    ]


def equality_rows(
    paper: str, tests: EqualityTests, style: Style = "apa", over: BlockTests | None = None, scale: Scale | None = None
) -> Rows:
    """ "No difference found" beside what would show equality. scale : of the data, for people."""
    scale = scale or Scale("", 1.0)
    level = f"{100 * (1 - 2 * tests.alpha):g}% intervals"
    bound, in_sd = (span_said(found, style) for found in (tests.bound * scale.factor, tests.bound_sd))
    effect = f"{level} of all differences lie within ± {f'{bound} {scale.unit}'.rstrip()} (± {in_sd} SD)"
    within, result = "", "no margin stated"
    if tests.margin:
        within = f" within ± {f'{tests.margin:g} SD' if tests.unit == 'sd' else activity(tests.margin, scale)}"
        result = f"{int(np.sum(tests.shown))} of {int(np.sum(tests.pairs))} pairs shown equal"
    rows = rows_of(paper, [(f"Equivalence (TOST){within}", result, effect)])
    if over is None:
        return rows
    # how much people differ, as a share of what is left unexplained
    name, share = "Variance components of the mixed model", over.mixed
    if share is None or not share.interval or np.isnan(share.interval[0]):
        name, share = f"Intraclass correlation of means, {over.agreement.estimate_name}", over.agreement
    return [*rows, CompanionRow(paper, name, effect_said(share, style))]
