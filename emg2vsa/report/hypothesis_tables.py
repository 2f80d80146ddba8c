"""The tests of section IV.B: each in numbers, beside its companions in words, and as a manuscript prints it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from emg2vsa.companions.groups import GroupTests
from emg2vsa.figures.activity_scale import ActivityScale
from emg2vsa.hypotheses import EFFECT_F, EPSILON, RHO, TARGET, Hypotheses
from emg2vsa.report.companion_rows import (
    Row,
    companion_table,
    equality_rows,
    group_rows,
    normality_rows,
    over_people_pair_rows,
    over_people_rows,
    pair_rows,
    variance_row,
)
from emg2vsa.report.outcome_text import STYLES, said
from emg2vsa.report.table import Cell, Column, Table, activity_column, rows_of
from emg2vsa.report.verdicts import how_many
from emg2vsa.report.wording import bounded
from emg2vsa.stats.clusters import Names
from emg2vsa.stats.outcome import Outcome
from emg2vsa.stats.power import power_table

_ANOVA = (
    Column("f", "F", digits=4), Column("df1", "df 1"), Column("df2", "df 2"), Column("p", "p"), Column("eta2", "η²"),
    Column("eta2_low", "η² low"), Column("eta2_high", "η² high"), Column("p_welch", "p Welch"),
    Column("p_kruskal", "p Kruskal-Wallis"), Column("p_brown_forsythe", "p Brown-Forsythe"), Column("bf01", "BF₀₁"),
)  # fmt: skip


def hypothesis_tables(found: Hypotheses, scale: ActivityScale) -> list[Table]:
    """normality, anova_participants, anova_specimens and lsd_pairs; a verdict_... of each and of the power;
    power_sensitivity; statements.
    """
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
        *_verdicts(found, scale),
        _statements(found),
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


_CAPTIONS = {
    "normality": "Gaussian clusters: the paper's test beside its companions",
    "participants": "Equal participants: the paper's test beside its companions",
    "specimens": "Different specimens: the paper's test beside its companions",
    "pairs": "Different pairs of specimens: the paper's test beside its companions",
    "power": "Sample size: the paper's computation beside others",
}
_PLANNED = "Sample size: 14 people by ten measurements"


def _verdicts(found: Hypotheses, scale: ActivityScale) -> list[Table]:
    """verdict_normality, verdict_participants, verdict_specimens, verdict_pairs, verdict_power, power_sensitivity."""
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
        "power": _power_rows(found),
    }  # fmt: skip
    tables = [companion_table(f"verdict_{name}", _CAPTIONS[name], of) for name, of in rows.items()]
    return [*tables, _sensitivity(found)]


def _power_rows(found: Hypotheses) -> list[Row]:
    power, people = found.power, f"{found.power.people} people" if found.power.people else "not defined"
    return [
        Row(
            _PLANNED,
            f"Repeated-measures F between repetitions: power {bounded(power.repetitions)} here",
            f"f = {EFFECT_F:g}, ρ = {RHO:g}, ε = {EPSILON:g}: chosen, not measured",
            "it is not the hypothesis of the study",
        ),
        Row(
            _PLANNED,
            f"Repeated-measures F between specimens: power {bounded(power.specimens)} here",
            f"{people} for a power of {bounded(TARGET, 2)}",
            "not defined" if np.isnan(power.specimens)
            else "no" if power.specimens >= TARGET else "yes: the sample is too small for it",
        ),
    ]  # fmt: skip


def _sensitivity(found: Hypotheses) -> Table:
    """How the power to tell the specimens apart hangs on what nobody knew beforehand."""
    people, specimens = found.participants.size, found.specimens.size
    columns = (
        Column("rho", "Correlation ρ"), Column("epsilon", "Sphericity ε"), Column("power", "Power here"),
        Column("people", f"People for a power of {bounded(TARGET, 2)}"),
    )  # fmt: skip
    caption = f"Power of {people} people to tell {specimens} specimens apart at f = {EFFECT_F:g}"
    if people < 2 or specimens < 2:
        return Table("power_sensitivity", caption, columns, ())
    table = power_table(people, specimens, EFFECT_F, alpha=found.alpha, power=TARGET)
    rows = tuple(
        (float(rho), float(epsilon), float(table.power[i, j]), int(table.people[i, j]))
        for i, rho in enumerate(table.rho)
        for j, epsilon in enumerate(table.epsilon)
    )
    return Table("power_sensitivity", caption, columns, rows)


_HEADS = {"apa": "APA", "ieee": "IEEE", "latex": "LaTeX", "plain": "Plain"}


def _statements(found: Hypotheses) -> Table:
    """key : what is said of what; method : with its variant; then the styles."""
    columns = (Column("key", "Of"), Column("method", "Test"), *(Column(style, _HEADS[style]) for style in STYLES))
    rows = tuple(
        (key, outcome.method, *(said(outcome, style) for style in STYLES)) for key, outcome in _outcomes(found)
    )
    return Table("statements", "Results as text", columns, rows)


def _outcomes(found: Hypotheses) -> Iterator[tuple[str, Outcome]]:
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
