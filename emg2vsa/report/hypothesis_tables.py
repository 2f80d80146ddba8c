"""The tests of section IV.B in numbers: every cluster, every analysis of variance, every pair, with all companions."""

from __future__ import annotations

import numpy as np

from emg2vsa.companions.groups import GroupTests
from emg2vsa.figures.activity_scale import ActivityScale
from emg2vsa.hypotheses import Hypotheses
from emg2vsa.report.activity_column import activity_column
from emg2vsa.report.table import Cell, Column, Table, rows_of
from emg2vsa.stats.clusters import Names

_ANOVA = (
    Column("f", "F", digits=4), Column("df1", "df 1"), Column("df2", "df 2"), Column("p", "p"), Column("eta2", "η²"),
    Column("eta2_low", "η² low"), Column("eta2_high", "η² high"), Column("p_welch", "p Welch"),
    Column("p_kruskal", "p Kruskal-Wallis"), Column("p_brown_forsythe", "p Brown-Forsythe"), Column("bf01", "BF₀₁"),
)  # fmt: skip


def hypothesis_tables(found: Hypotheses, scale: ActivityScale) -> list[Table]:
    """normality, anova_participants, anova_specimens and lsd_pairs."""
    of_specimen = (Column("n_participants", "Participants"), Column("n", "Trials"))
    between = found.tests.between_blocks
    counts = (np.count_nonzero(between.anova.count, axis=1), np.sum(between.anova.count, axis=1))
    return [
        _normality(found),
        Table(
            "anova_participants",
            "One-way ANOVA of b between participants, one for each specimen, and its companions",
            (Column("specimen", "Specimen"), *_ANOVA, *of_specimen),
            _anova_rows(found.specimens, between, *counts),
        ),
        Table(
            "anova_specimens",
            "One-way ANOVA of b between specimens, one for each participant, and its companions",
            (Column("participant", "Participant"), *_ANOVA),
            _anova_rows(found.participants, found.tests.between_groups),
        ),
        _pairs(found, scale),
    ]


def _normality(found: Hypotheses) -> Table:
    tests = found.tests.normality
    columns = (
        Column("participant", "Participant"), Column("specimen", "Specimen"), Column("n", "n"),
        Column("d_standardised", "D standardised"), Column("p_standardised", "p standardised"),
        Column("p_lilliefors", "p Lilliefors"), Column("w", "W Shapiro-Wilk"), Column("p_shapiro", "p Shapiro-Wilk"),
        Column("d_raw", "D raw"), Column("p_raw", "p raw"),
    )  # fmt: skip
    rows = rows_of(
        np.repeat(found.participants, found.specimens.size), np.tile(found.specimens, found.participants.size),
        found.count.ravel(), tests.standardised.d, tests.standardised.p, tests.lilliefors.p, tests.shapiro.w,
        tests.shapiro.p, tests.raw.d, tests.raw.p,
    )  # fmt: skip
    caption = (
        "Normality of each cluster of b: Kolmogorov-Smirnov, standardised by its own mean and SD and raw against "
        "N(0, 1); Lilliefors; Shapiro-Wilk"
    )
    return Table("normality", caption, columns, rows)


def _anova_rows(names: Names, tests: GroupTests, *more: np.ndarray) -> tuple[tuple[Cell, ...], ...]:
    a = tests.anova
    return rows_of(
        names[: a.f.size], a.f, a.df1, a.df2, a.p, a.eta2, tests.eta2_low, tests.eta2_high, tests.welch.p,
        tests.kruskal.p, tests.brown_forsythe.anova.p, tests.bayes.bf01, *more,
    )  # fmt: skip


def _pairs(found: Hypotheses, scale: ActivityScale) -> Table:
    tests = found.tests.pairs
    lsd = tests.lsd
    d, q = lsd.p.shape
    columns = (
        Column("participant", "Participant"), Column("first", "First"), Column("second", "Second"),
        activity_column("difference_v", "Difference", scale), activity_column("lo_v", "Low", scale),
        activity_column("hi_v", "High", scale), Column("t", "t"), Column("df", "df"), Column("p", "p LSD"),
        Column("p_holm", "p Holm"), Column("p_tukey", "p Tukey"), Column("p_games_howell", "p Games-Howell"),
        Column("p_fdr", "p FDR"), Column("p_dunn", "p Dunn"), Column("p_mann_whitney", "p Mann-Whitney, Holm"),
        Column("g", "g"), Column("g_low", "g low"), Column("g_high", "g high"),
    )  # fmt: skip
    names = found.specimens if d and found.specimens.size > 1 else np.array(["", ""])
    numbers = (
        lsd.difference, lsd.low, lsd.high, lsd.statistic, lsd.df, lsd.p, tests.p_holm, tests.tukey.p,
        tests.games_howell.p, tests.p_fdr, tests.dunn.p, tests.p_rank_holm, tests.g, tests.g_low, tests.g_high,
    )  # fmt: skip
    rows = rows_of(
        np.repeat(found.participants[:d], q), np.tile(names[lsd.first], d), np.tile(names[lsd.second], d),
        *(array.ravel() for array in numbers),
    )  # fmt: skip
    caption = (
        "Pairs of specimens: Fisher's LSD on b, not corrected for the number of pairs, with the p of tests that are "
        "(over the pairs of a participant) and Hedges' g; FDR: false discovery rate"
    )
    return Table("lsd_pairs", caption, columns, rows)
