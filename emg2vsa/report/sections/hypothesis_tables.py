"""The tables of the tests of section IV.B, each test of the paper beside its companions."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from emg2vsa.companions.groups import GroupTests
from emg2vsa.figures.palette import ActivityScale
from emg2vsa.hypotheses import Hypotheses
from emg2vsa.report import companion_rows as beside
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.outcome_text import STYLES, said
from emg2vsa.report.section import Quantities
from emg2vsa.report.table import FEW_ON_PAGE, Column, Columns, Table, activity_column, columns, table_of
from emg2vsa.report.wording import listed
from emg2vsa.statistics.mixed_variances import SOURCES
from emg2vsa.statistics.outcome import Outcome


def hypothesis_tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    if (found := results.recorded.hypotheses) is None:
        return
    across, within = found.tests.between_blocks, found.tests.between_groups
    specimens: Columns = {Column("specimen", "Specimen"): found.specimens[: across.anova.f.size]}
    people: Columns = {Column("participant", "Participant"): found.participants[: within.anova.f.size]}
    counts: Columns = {
        Column("n_participants", "Participants"): np.count_nonzero(across.anova.count, axis=1),
        Column("n", "Trials"): np.sum(across.anova.count, axis=1),
    }
    caption = "One-way ANOVA of b between {}, one for each {}, and its companions"
    between = caption.format("participants", "specimen"), caption.format("specimens", "participant")
    yield _normality(found)
    yield table_of("anova_participants", between[0], specimens | _anova(across) | counts, FEW_ON_PAGE)
    yield table_of("anova_specimens", between[1], people | _anova(within), FEW_ON_PAGE)
    yield _pairs(found, results.scale)
    yield from _compared(found, results.scale)
    yield from _models(found, results.scale)
    yield _statements(found)


def _normality(found: Hypotheses) -> Table:
    tests = found.tests.normality
    values: Columns = {
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
    return table_of("normality", caption, values, FEW_ON_PAGE)


def _anova(tests: GroupTests) -> Columns:
    return {
        **columns(tests.anova, "f", "df1", "df2", "p"),
        **columns(tests, "omega2", "eta2_low", "eta2_high"),
        **columns(tests.anova, "eta2"),
        Column("p_welch", "p Welch"): tests.welch.p,
        Column("p_kruskal", "p Kruskal-Wallis"): tests.kruskal.p,
        Column("p_brown_forsythe", "p Brown-Forsythe"): tests.brown_forsythe.p,
        Column("bf01", "BF₀₁"): tests.bayes.bf01,
    }


def _pairs(found: Hypotheses, scale: ActivityScale) -> Table:
    tests, lsd = found.tests.pairs, found.tests.pairs.lsd
    d, n_pairs = lsd.p.shape
    names = np.append(found.specimens, [""] * 2)  # fewer than two specimens have no pair
    values: Columns = {
        Column("participant", "Participant"): np.repeat(found.participants[:d], n_pairs),
        Column("first", "First"): np.tile(names[lsd.first], d),
        Column("second", "Second"): np.tile(names[lsd.second], d),
        activity_column("difference_v", "Difference", scale): lsd.difference,
        activity_column("lo_v", "Low", scale): lsd.low,
        activity_column("hi_v", "High", scale): lsd.high,
        Column("t", "t"): lsd.statistic,
        Column("df", "df"): lsd.df,
        Column("p", "p LSD"): lsd.p,
        **{Column(f"p_{key}", f"p {beside.CORRECTED[key]}"): p for key, p in tests.corrected.items()},
        **columns(tests, "g", "g_low", "g_high"),
    }
    caption = (
        "Pairs of specimens: Fisher's LSD on b, not corrected for the number of pairs; the p of tests that are "
        "corrected over the pairs of a participant; Hedges' g (FDR: false discovery rate)"
    )
    flat = {column: np.ravel(np.asarray(of)) for column, of in values.items()}
    return table_of("lsd_pairs", caption, flat, FEW_ON_PAGE)


_FORMS = (
    "the paper does not say which form of its test it ran. Standardised by the sample's own mean and SD, its p is far "
    "too large; on raw values, it hardly looks at their shape"
)
_BOUND = "an ANOVA cannot show equality; the equivalence test bounds the difference that it may have missed"
_UNITS = (
    "the repeated-measures ANOVA, the mixed model and Friedman's test are about people, the other tests about one "
    "participant's repetitions each"
)


def _compared(found: Hypotheses, scale: ActivityScale) -> Iterator[Table]:
    tests, alpha, blocks = found.tests, found.alpha, found.tests.blocks
    across, within = tests.between_blocks, tests.between_groups
    rows = beside.normality_rows(tests.normality, alpha, "clusters")
    yield beside.companion_table("normality", "Gaussian clusters", rows, _FORMS)
    if across.anova.f.size:
        paper = beside.anova_said(across, alpha, "specimens")
        equal = beside.equality_rows(paper, tests.equality, over=blocks, scale=scale)
        rows = beside.group_rows(across, alpha, "specimens", equal=equal)
        yield beside.companion_table("participants", "Equal participants", rows, _BOUND)
    if within.anova.f.size:
        rows = beside.group_rows(within, alpha, "participants", over=blocks)
        yield beside.companion_table("specimens", "Different specimens", rows, *([_UNITS] if blocks else []))
        over = beside.pair_rows(tests.pairs, alpha, over=blocks) if blocks else []
        rows = [*over, *beside.pair_rows(tests.pairs, alpha)]
        yield beside.companion_table("pairs", "Different pairs of specimens", rows)


def _models(found: Hypotheses, scale: ActivityScale) -> Iterator[Table]:
    """What the mixed model says of the scatter of b, and the trend over repetitions."""
    blocks = found.tests.blocks
    if blocks is not None and (of := blocks.variances) is not None:
        scatter: Columns = {
            Column("source", "Source"): SOURCES,
            activity_column("sd_v", "SD of b", scale): of.sd,
            activity_column("low_v", "Low", scale): of.low,
            activity_column("high_v", "High", scale): of.high,
            Column("ratio", "SD / SD of repetitions"): [*of.ratio[:2].tolist(), 1.0],
            Column("ratio_low", "Low"): [*of.ratio_low[:2].tolist(), None],
            Column("ratio_high", "High"): [*of.ratio_high[:2].tolist(), None],
        }
        caption = "Scatter of b by the mixed model: standard deviations (REML) and their profile-likelihood intervals"
        if zero := [source for source, sd in zip(SOURCES, of.sd, strict=True) if sd == 0]:
            caption += f". The likelihood is largest where {listed(zero)} do not scatter: only the upper limit informs"
        yield table_of("mixed_sd", caption, scatter)
    yield _people(found, scale)
    if blocks is not None and blocks.residuals is not None:
        fitted: Columns = {activity_column("fitted_v", "Fitted b", scale): blocks.residuals.fitted}
        caption = "Residuals of the mixed model, for a QQ plot and for residuals against fitted values"
        yield table_of("mixed_residuals", caption, fitted | columns(blocks.residuals, "residual", "quantile"))
    slopes: Columns = {
        Column("participant", "Participant"): found.trend.blocks,
        activity_column("slope_v", "Change of b per repetition", scale): found.trend.slope,
    }
    yield table_of("trend", "Trend of b over the repetitions of each participant", slopes, FEW_ON_PAGE)


def _people(found: Hypotheses, scale: ActivityScale) -> Table:
    """b of each person, by the presses of the recording and in the hierarchy of the study."""
    people, blocks = found.people, found.tests.blocks
    model = np.full((6, people.mean.size), np.nan)
    if blocks is not None and (of := blocks.predicted) is not None:
        whole = (np.repeat(each, found.specimens.size) for each in (of.person, of.person_low, of.person_high))
        model = np.stack([of.cell.ravel(), of.cell_low.ravel(), of.cell_high.ravel(), *whole])
    heads = ("Mean b", "Low", "High", "Shrunken b", "Low", "High", "Over the specimens", "Low", "High")
    keys = [f"{of}{end}v" for of in ("b_", "shrunken_", "person_") for end in ("", "low_", "high_")]
    values: Columns = {
        Column("participant", "Participant"): people.participant, Column("specimen", "Specimen"): people.specimen,
        Column("presses", "Presses"): people.presses,
        **{
            activity_column(key, head, scale): of
            for key, head, of in zip(keys, heads, (people.mean, people.low, people.high, *model), strict=True)
        },
    }  # fmt: skip
    caption = (
        "b of each person: mean over presses, whose interval holds how presses differ, pooled over the study; then "
        "what the mixed model predicts for the person on the specimen, and over all specimens, drawn towards the study"
    )
    return table_of("person_slopes", caption, values, FEW_ON_PAGE)


def _statements(found: Hypotheses) -> Table:
    every = list(outcomes(found))
    values: Columns = {
        Column("key", "Of"): [key for key, _ in every],
        Column("method", "Test"): [outcome.method for _, outcome in every],
    }
    for style, head in zip(STYLES, ("APA", "IEEE", "LaTeX", "Plain"), strict=True):
        values[Column(style, head)] = [said(outcome, style) for _, outcome in every]
    return table_of("statements", "Results as text", values, FEW_ON_PAGE)


def outcomes(found: Hypotheses) -> Iterator[tuple[str, Outcome]]:
    """Every test of the study, with what it tests."""
    tests = found.tests
    every = [("over people", tests.blocks.outcomes())] if tests.blocks is not None else []
    blocks, groups = tests.between_blocks, tests.between_groups
    specimens, people = found.specimens[: blocks.anova.f.size], found.participants[: groups.anova.f.size]
    every += [(f"participants on {name}", blocks.outcomes(i)) for i, name in enumerate(specimens.tolist())]
    every += [(f"specimens of {name}", groups.outcomes(i)) for i, name in enumerate(people.tolist())]
    if found.worst[0] >= 0:
        every.append((f"worst pair, {found.worst_pair}", tests.pairs.outcomes(*found.worst)))
    yield from ((of, outcome) for of, several in every for outcome in several)
