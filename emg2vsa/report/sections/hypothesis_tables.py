"""The tables of the tests of section IV.B, each test of the paper beside its companions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from emg2vsa.companions.groups import GroupTests
from emg2vsa.figures.activity_scale import ActivityScale
from emg2vsa.hypotheses import Hypotheses
from emg2vsa.report.companion_rows import (
    companion_table,
    equality_rows,
    group_rows,
    normality_rows,
    over_people_pair_rows,
    over_people_rows,
    pair_rows,
    variance_row,
)
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.outcome_text import STYLES, said
from emg2vsa.report.section import Quantities
from emg2vsa.report.table import Column, Row, Table, activity_column, rows_of
from emg2vsa.report.verdicts import how_many
from emg2vsa.statistics.clusters import Names
from emg2vsa.statistics.outcome import Outcome

_ANOVA = (
    Column("f", "F", digits=4), Column("df1", "df 1"), Column("df2", "df 2"), Column("p", "p"), Column("eta2", "η²"),
    Column("omega2", "ω²"), Column("eta2_low", "ω² low"), Column("eta2_high", "ω² high"), Column("p_welch", "p Welch"),
    Column("p_kruskal", "p Kruskal-Wallis"), Column("p_brown_forsythe", "p Brown-Forsythe"), Column("bf01", "BF₀₁"),
)  # fmt: skip


def hypothesis_tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    found = results.recorded.hypotheses
    if found is None:
        return
    between = found.tests.between_blocks
    counts = {
        "n_participants": np.count_nonzero(between.anova.count, axis=1),
        "n": np.sum(between.anova.count, axis=1),
    }
    yield _normality(found)
    yield Table(
        "anova_participants",
        "One-way ANOVA of b between participants, one for each specimen, and its companions",
        (Column("specimen", "Specimen"), *_ANOVA, Column("n_participants", "Participants"), Column("n", "Trials")),
        _anova_rows("specimen", found.specimens, between, counts),
    )
    yield Table(
        "anova_specimens",
        "One-way ANOVA of b between specimens, one for each participant, and its companions",
        (Column("participant", "Participant"), *_ANOVA),
        _anova_rows("participant", found.participants, found.tests.between_groups, {}),
    )
    yield _pairs(found, results.scale)
    yield from _verdicts(found, results.scale)
    yield _statements(found)


def _normality(found: Hypotheses) -> Table:
    tests = found.tests.normality
    columns = (
        Column("participant", "Participant"), Column("specimen", "Specimen"), Column("n", "n"),
        Column("d_standardised", "D standardised"), Column("p_standardised", "p standardised"),
        Column("p_lilliefors", "p Lilliefors"), Column("w", "W Shapiro-Wilk"), Column("p_shapiro", "p Shapiro-Wilk"),
        Column("d_raw", "D raw"), Column("p_raw", "p raw"),
    )  # fmt: skip
    rows = rows_of(
        {
            "participant": np.repeat(found.participants, found.specimens.size),
            "specimen": np.tile(found.specimens, found.participants.size),
            "n": found.count.ravel(),
            "d_standardised": tests.standardised.statistic,
            "p_standardised": tests.standardised.p,
            "p_lilliefors": tests.lilliefors.p,
            "w": tests.shapiro.statistic,
            "p_shapiro": tests.shapiro.p,
            "d_raw": tests.raw.statistic,
            "p_raw": tests.raw.p,
        }
    )
    caption = (
        "Normality of each cluster of b: Kolmogorov-Smirnov, standardised by its own mean and SD and raw against "
        "N(0, 1); Lilliefors; Shapiro-Wilk"
    )
    return Table("normality", caption, columns, rows)


def _anova_rows(design: str, names: Names, tests: GroupTests, more: dict[str, np.ndarray]) -> Sequence[Row]:
    anova = tests.anova
    own: dict[str, np.ndarray] = {design: names[: anova.f.size]}
    own |= {key: getattr(anova, key) for key in ("f", "df1", "df2", "p", "eta2")}
    own |= {"omega2": tests.omega2, "eta2_low": tests.eta2_low, "eta2_high": tests.eta2_high, "p_welch": tests.welch.p}
    own |= {"p_kruskal": tests.kruskal.p, "p_brown_forsythe": tests.brown_forsythe.p, "bf01": tests.bayes.bf01}
    return rows_of(own | more)


def _pairs(found: Hypotheses, scale: ActivityScale) -> Table:
    tests = found.tests.pairs
    lsd = tests.lsd
    d, n_pairs = lsd.p.shape
    columns = (
        Column("participant", "Participant"), Column("first", "First"), Column("second", "Second"),
        activity_column("difference_v", "Difference", scale), activity_column("lo_v", "Low", scale),
        activity_column("hi_v", "High", scale), Column("t", "t"), Column("df", "df"), Column("p", "p LSD"),
        Column("p_holm", "p Holm"), Column("p_tukey", "p Tukey"), Column("p_games_howell", "p Games-Howell"),
        Column("p_fdr", "p FDR"), Column("p_dunn", "p Dunn"), Column("p_mann_whitney", "p Mann-Whitney, Holm"),
        Column("g", "g"), Column("g_low", "g low"), Column("g_high", "g high"),
    )  # fmt: skip
    names = found.specimens if d and found.specimens.size > 1 else np.array(["", ""])
    numbers = {
        "difference_v": lsd.difference, "lo_v": lsd.low, "hi_v": lsd.high, "t": lsd.statistic, "df": lsd.df,
        "p": lsd.p, "p_holm": tests.p_holm, "p_tukey": tests.tukey.p, "p_games_howell": tests.games_howell.p,
        "p_fdr": tests.p_fdr, "p_dunn": tests.dunn.p, "p_mann_whitney": tests.p_rank_holm, "g": tests.g,
        "g_low": tests.g_low, "g_high": tests.g_high,
    }  # fmt: skip
    who = {
        "participant": np.repeat(found.participants[:d], n_pairs),
        "first": np.tile(names[lsd.first], d),
        "second": np.tile(names[lsd.second], d),
    }
    caption = (
        "Pairs of specimens: Fisher's LSD on b, not corrected for the number of pairs; the p of tests that are "
        "corrected over the pairs of a participant; Hedges' g (FDR: false discovery rate)"
    )
    rows = rows_of(who | {key: array.ravel() for key, array in numbers.items()})
    return Table("lsd_pairs", caption, columns, rows)


_CAPTIONS = {
    "normality": "Gaussian clusters: the paper's test beside its companions",
    "participants": "Equal participants: the paper's test beside its companions",
    "specimens": "Different specimens: the paper's test beside its companions",
    "pairs": "Different pairs of specimens: the paper's test beside its companions",
}


def _verdicts(found: Hypotheses, scale: ActivityScale) -> Iterator[Table]:
    tests, alpha = found.tests, found.alpha
    across, within = tests.between_blocks, tests.between_groups
    equal = f"One-way ANOVA: {how_many(across.anova.p, alpha, 'specimens')}"
    differ = f"One-way ANOVA: {how_many(within.anova.p, alpha, 'participants')}"
    rows = {
        "normality": normality_rows(tests.normality, alpha, "clusters"),
        "participants": [
            *group_rows(across, alpha, "specimens"),
            *equality_rows(equal, tests.equality, tests.blocks, scale.factor, scale.unit),
            variance_row(across, alpha, "specimens"),
        ] if across.anova.f.size else [],
        "specimens": [
            *group_rows(within, alpha, "participants"),
            *(over_people_rows(differ, within.anova.p, tests.blocks, alpha) if tests.blocks else []),
            variance_row(within, alpha, "participants"),
        ] if within.anova.f.size else [],
        "pairs": [
            *pair_rows(tests.pairs, alpha),
            *(over_people_pair_rows(tests.pairs, tests.blocks, alpha) if tests.blocks else []),
        ] if within.anova.f.size else [],
    }  # fmt: skip
    for name, of in rows.items():
        yield companion_table(f"verdict_{name}", _CAPTIONS[name], of)


_HEADS = {"apa": "APA", "ieee": "IEEE", "latex": "LaTeX", "plain": "Plain"}


def _statements(found: Hypotheses) -> Table:
    columns = (Column("key", "Of"), Column("method", "Test"), *(Column(style, _HEADS[style]) for style in STYLES))
    rows = tuple(
        {"key": key, "method": outcome.method} | {style: said(outcome, style) for style in STYLES}
        for key, outcome in outcomes(found)
    )
    return Table("statements", "Results as text", columns, rows)


def outcomes(found: Hypotheses) -> Iterator[tuple[str, Outcome]]:
    """Every test of the study, with what it tests."""
    tests = found.tests
    if tests.blocks is not None:
        for outcome in tests.blocks.outcomes():
            yield "over people", outcome
    for i, specimen in enumerate(found.specimens[: tests.between_blocks.anova.f.size].tolist()):
        for outcome in tests.between_blocks.outcomes(i):
            yield f"participants on {specimen}", outcome
    for i, participant in enumerate(found.participants[: tests.between_groups.anova.f.size].tolist()):
        for outcome in tests.between_groups.outcomes(i):
            yield f"specimens of {participant}", outcome
    if found.worst[0] >= 0:
        for outcome in tests.pairs.outcomes(*found.worst):
            yield f"worst pair, {found.worst_pair}", outcome
