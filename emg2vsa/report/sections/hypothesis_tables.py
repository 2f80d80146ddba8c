"""The tables of the tests of section IV.B, each test of the paper beside its companions."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from emg2vsa.companions.groups import GroupTests
from emg2vsa.figures.palette import ActivityScale
from emg2vsa.hypotheses import Hypotheses
from emg2vsa.report.companion_rows import (
    companion_table,
    equality_rows,
    group_rows,
    how_many,
    normality_rows,
    over_people_pair_rows,
    over_people_rows,
    pair_rows,
    variance_row,
)
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.outcome_text import STYLES, said
from emg2vsa.report.section import Quantities
from emg2vsa.report.table import Column, Columns, Table, activity_column, table_of
from emg2vsa.statistics.outcome import Outcome


def hypothesis_tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    found = results.recorded.hypotheses
    if found is None:
        return
    across, within = found.tests.between_blocks, found.tests.between_groups
    specimens = {Column("specimen", "Specimen"): found.specimens[: across.anova.f.size]}
    counts = {
        Column("n_participants", "Participants"): np.count_nonzero(across.anova.count, axis=1),
        Column("n", "Trials"): np.sum(across.anova.count, axis=1),
    }
    people = {Column("participant", "Participant"): found.participants[: within.anova.f.size]}
    caption = "One-way ANOVA of b between {}, one for each {}, and its companions"
    yield _normality(found)
    yield table_of(
        "anova_participants", caption.format("participants", "specimen"), specimens | _anova(across) | counts
    )
    yield table_of("anova_specimens", caption.format("specimens", "participant"), people | _anova(within))
    yield _pairs(found, results.scale)
    yield from _compared(found, results.scale)
    yield _statements(found)


def _normality(found: Hypotheses) -> Table:
    tests = found.tests.normality
    columns: Columns = {
        Column("participant", "Participant"): np.repeat(found.participants, found.specimens.size),
        Column("specimen", "Specimen"): np.tile(found.specimens, found.participants.size),
        Column("n", "n"): found.count.ravel(),
        Column("d_standardised", "D standardised"): tests.standardised.statistic,
        Column("p_standardised", "p standardised"): tests.standardised.p,
        Column("p_lilliefors", "p Lilliefors"): tests.lilliefors.p,
        Column("w", "W Shapiro-Wilk"): tests.shapiro.statistic,
        Column("p_shapiro", "p Shapiro-Wilk"): tests.shapiro.p,
        Column("d_raw", "D raw"): tests.raw.statistic,
        Column("p_raw", "p raw"): tests.raw.p,
    }
    caption = (
        "Normality of each cluster of b: Kolmogorov-Smirnov, standardised by its own mean and SD and raw against "
        "N(0, 1); Lilliefors; Shapiro-Wilk"
    )
    return table_of("normality", caption, columns)


def _anova(tests: GroupTests) -> Columns:
    return {
        Column("f", "F", digits=4): tests.anova.f,
        Column("df1", "df 1"): tests.anova.df1,
        Column("df2", "df 2"): tests.anova.df2,
        Column("p", "p"): tests.anova.p,
        Column("omega2", "ω²"): tests.omega2,
        Column("eta2_low", "ω² low"): tests.eta2_low,
        Column("eta2_high", "ω² high"): tests.eta2_high,
        Column("eta2", "η²"): tests.anova.eta2,
        Column("p_welch", "p Welch"): tests.welch.p,
        Column("p_kruskal", "p Kruskal-Wallis"): tests.kruskal.p,
        Column("p_brown_forsythe", "p Brown-Forsythe"): tests.brown_forsythe.p,
        Column("bf01", "BF₀₁"): tests.bayes.bf01,
    }


def _pairs(found: Hypotheses, scale: ActivityScale) -> Table:
    tests = found.tests.pairs
    lsd = tests.lsd
    d, n_pairs = lsd.p.shape
    names = found.specimens if d and found.specimens.size > 1 else np.array(["", ""])
    numbers = {
        activity_column("difference_v", "Difference", scale): lsd.difference,
        activity_column("lo_v", "Low", scale): lsd.low,
        activity_column("hi_v", "High", scale): lsd.high,
        Column("t", "t"): lsd.statistic,
        Column("df", "df"): lsd.df,
        Column("p", "p LSD"): lsd.p,
        Column("p_holm", "p Holm"): tests.p_holm,
        Column("p_tukey", "p Tukey"): tests.tukey.p,
        Column("p_games_howell", "p Games-Howell"): tests.games_howell.p,
        Column("p_fdr", "p FDR"): tests.p_fdr,
        Column("p_dunn", "p Dunn"): tests.dunn.p,
        Column("p_mann_whitney", "p Mann-Whitney, Holm"): tests.p_rank_holm,
        Column("g", "g"): tests.g,
        Column("g_low", "g low"): tests.g_low,
        Column("g_high", "g high"): tests.g_high,
    }
    who = {
        Column("participant", "Participant"): np.repeat(found.participants[:d], n_pairs),
        Column("first", "First"): np.tile(names[lsd.first], d),
        Column("second", "Second"): np.tile(names[lsd.second], d),
    }
    caption = (
        "Pairs of specimens: Fisher's LSD on b, not corrected for the number of pairs; the p of tests that are "
        "corrected over the pairs of a participant; Hedges' g (FDR: false discovery rate)"
    )
    return table_of("lsd_pairs", caption, who | {column: values.ravel() for column, values in numbers.items()})


def _compared(found: Hypotheses, scale: ActivityScale) -> Iterator[Table]:
    tests, alpha, blocks = found.tests, found.alpha, found.tests.blocks
    across, within = tests.between_blocks, tests.between_groups
    yield companion_table("normality", "Gaussian clusters", normality_rows(tests.normality, alpha, "clusters"))
    if across.anova.f.size:
        equal = f"One-way ANOVA: {how_many(across.anova.p, alpha, 'specimens')}"
        rows = [
            *group_rows(across, alpha, "specimens"),
            *equality_rows(equal, tests.equality, blocks, scale.factor, scale.unit),
            variance_row(across, alpha, "specimens"),
        ]
        yield companion_table("participants", "Equal participants", rows)
    if within.anova.f.size:
        differ = f"One-way ANOVA: {how_many(within.anova.p, alpha, 'participants')}"
        over = over_people_rows(differ, blocks) if blocks else []
        rows = [*over, *group_rows(within, alpha, "participants"), variance_row(within, alpha, "participants")]
        yield companion_table("specimens", "Different specimens", rows)
        over = over_people_pair_rows(tests.pairs, blocks, alpha) if blocks else []
        yield companion_table("pairs", "Different pairs of specimens", [*over, *pair_rows(tests.pairs, alpha)])


def _statements(found: Hypotheses) -> Table:
    every = list(outcomes(found))
    columns: Columns = {
        Column("key", "Of"): [key for key, _ in every],
        Column("method", "Test"): [outcome.method for _, outcome in every],
        **{
            Column(style, {"latex": "LaTeX", "plain": "Plain"}.get(style, style.upper())): [
                said(outcome, style) for _, outcome in every
            ]
            for style in STYLES
        },
    }
    return table_of("statements", "Results as text", columns)


def outcomes(found: Hypotheses) -> Iterator[tuple[str, Outcome]]:
    """Every test of the study, with what it tests."""
    tests = found.tests
    across, within = tests.between_blocks, tests.between_groups
    if tests.blocks is not None:
        yield from (("over people", outcome) for outcome in tests.blocks.outcomes())
    for i, specimen in enumerate(found.specimens[: across.anova.f.size].tolist()):
        yield from ((f"participants on {specimen}", outcome) for outcome in across.outcomes(i))
    for i, participant in enumerate(found.participants[: within.anova.f.size].tolist()):
        yield from ((f"specimens of {participant}", outcome) for outcome in within.outcomes(i))
    if found.worst[0] >= 0:
        yield from ((f"worst pair, {found.worst_pair}", outcome) for outcome in tests.pairs.outcomes(*found.worst))
