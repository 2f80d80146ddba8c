"""The tests of section IV.B in plain words: the claim, the paper's test beside its companions, and what to mind."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from casr import html
from emg2vsa.figures.activity_scale import ActivityScale
from emg2vsa.hypotheses import Hypotheses
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.outcome_text import said, statistic_said
from emg2vsa.report.quantity import Quantity
from emg2vsa.report.study_tables import scale_of
from emg2vsa.report.table import Table
from emg2vsa.report.verdicts import dunn_bounds
from emg2vsa.report.wording import NO_BREAK, activity, bounded, listed, number, p_text, percent
from emg2vsa.stats.ks_exact import ks_survival
from emg2vsa.stats.power import MEANING


def hypotheses(results: StudyResults, found: Mapping[str, Quantity], tables: Mapping[str, Table]) -> str:
    """All five: Gaussian clusters, equal participants, different specimens, their pairs, power."""
    title = "Hypotheses"
    tested = results.hypotheses
    if tested is None:
        return html.section("hypotheses", title, html.paragraph(results.why_absent("hypotheses")))
    return html.section(
        "hypotheses",
        title,
        html.paragraph(
            f"All tests are on the slopes b, at α = {tested.alpha:g}. Each table sets the paper's test beside the "
            "tests that a referee may ask for, and says whether they decide otherwise."
        ),
        _normality(tested, tables),
        _participants(tested, found, tables),
        _specimens(tested, found, tables),
        _pairs(tested, found, tables, scale_of(results)),
        _power(tables),
        html.heading("Notes of the tests") + html.bullets(tested.notes) if tested.notes else "",
        html.details("Every result as APA, IEEE, LaTeX and plain text", tables["statements"].html()),
    )


def _normality(tested: Hypotheses, tables: Mapping[str, Table]) -> str:
    return (
        html.heading("Is each cluster Gaussian?")
        + html.paragraph("Claim: the slopes of one participant on one specimen come from a Gaussian distribution.")
        + tables["verdict_normality"].html()
        + html.paragraph(
            "Two tests go by the name of Kolmogorov-Smirnov, and the paper does not say which it ran. Standardised by "
            "the sample's own mean and SD, its p is far too large: passing says next to nothing. Lilliefors' p is the "
            f"right one for the same D. {_raw_bound(tested)} No later test should be chosen by the outcome of these."
        )
        + html.details("Every cluster", tables["normality"].html())
    )


def _raw_bound(tested: Hypotheses) -> str:
    """How little the raw test looks at the shape of positive values, from the sizes of the clusters at hand."""
    raw = tested.tests.normality.raw
    sizes = raw.n[np.isfinite(raw.p)]
    bounds = [
        f"at most {bounded(p, 4)} for {n} values"
        for n in sorted({int(np.min(sizes)), int(np.max(sizes))} if sizes.size else ())
        for p in ks_survival([0.5], [n]).tolist()
    ]
    at = f", and p is {' and '.join(bounds)}, whatever their shape" if bounds else ""
    return f"On raw values, positive ones have D of .5 or more{at}."


def _participants(tested: Hypotheses, found: Mapping[str, Quantity], tables: Mapping[str, Table]) -> str:
    key = "hypotheses.between_participants"
    title = html.heading("Are participants equal?") + html.paragraph(
        "Claim: people palpate the same specimen with the same slope."
    )
    if not found[f"{key}.tested"]:
        return title + html.paragraph("Not tested: this takes usable trials of two participants or more.")
    tests = tested.tests.between_blocks
    worst = int(np.nanargmin(tests.anova.p))
    shown = (
        f"Participants differ significantly for {found[f'{key}.significant']} of {found[f'{key}.tested']} specimens. "
        f"Smallest p: {tested.specimens[worst]}, {said(tests.anova_outcome(worst))}."
    )
    mind = (
        "Not having found a difference is not equality; it bounds what could have been missed. The table gives that "
        "bound, and the spread of people beside that of repetitions. Volts depend on electrodes and skin: without "
        "normalisation, equal people would be a surprise."
    )
    return (
        title
        + html.paragraph(shown)
        + tables["verdict_participants"].html()
        + html.paragraph(_chance(found, key, "tests") + mind)
        + html.details("ANOVA of every specimen", tables["anova_participants"].html())
    )


def _specimens(tested: Hypotheses, found: Mapping[str, Quantity], tables: Mapping[str, Table]) -> str:
    title = html.heading("Do specimens differ?") + html.paragraph(
        "Claim: for every participant, the specimens have different slopes."
    )
    if not found["hypotheses.between_specimens.tested"]:
        return title + html.paragraph("Not tested: this takes usable trials on two specimens or more.")
    mind = (
        "The paper runs one ANOVA a person, in which repetitions count as independent: each speaks of that person's "
        "repetitions, not of people. The mixed model, the repeated-measures ANOVA and Friedman's test have people as "
        "their sample. Repetitions on one block of silicone are likewise repetitions of one specimen."
    )
    if tested.tests.blocks is None:
        mind = "With one participant, every test speaks of that person's repetitions, not of people."
    return (
        title
        + tables["verdict_specimens"].html()
        + html.paragraph(mind)
        + html.details("ANOVA of every participant", tables["anova_specimens"].html())
    )


def _pairs(tested: Hypotheses, found: Mapping[str, Quantity], tables: Mapping[str, Table], scale: ActivityScale) -> str:
    if not found["hypotheses.between_specimens.tested"]:
        return ""
    q = tested.tests.pairs.first.size
    mind = (
        f"With {q} pairs a participant, the uncorrected LSD does not hold its error. Specimens that were kept because "
        "they came out significant make the worst p look better than it is."
    )
    return (
        html.heading("Which specimens differ?")
        + html.paragraph(
            f"Claim: {listed(tested.kept)} differ pairwise, for every participant. {_worst(tested, scale)}"
        )
        + tables["verdict_pairs"].html()
        + html.paragraph(_chance(found, "hypotheses.pairs", "uncorrected pairs") + mind)
        + html.paragraph(_rank_bound(tested))
        + html.details(f"All {tested.tests.pairs.lsd.p.size} pairs", tables["lsd_pairs"].html())
    )


def _rank_bound(tested: Hypotheses) -> str:
    """What p the mean-rank comparison can reach at all, for the usual participant."""
    usual = np.full(tested.specimens.size, np.max(tested.count))
    bounds = dunn_bounds(usual)
    if bounds is None:
        return ""
    uncorrected, corrected = (bounded(bound, 4) for bound in bounds)
    return (
        f"Dunn's test pools the ranks of all specimens. Even if {usual.size} groups of {usual[0]} do not overlap, its "
        f"worst pair has p = {uncorrected} or more, {corrected} with Bonferroni: a large p there says nothing against "
        "a difference."
    )


def _chance(found: Mapping[str, Quantity], key: str, many: str) -> str:
    """What a family of tests rejects by chance alone."""
    n = int(found[f"{key}.tested"])
    if n < 2:
        return ""
    chance = float(found[f"{key}.chance_of_any"])
    shown = f"more than 99.9{NO_BREAK}%" if chance > 0.999 else percent(chance)
    return (
        f"If nothing differed at all, at least one of {n} {many} would come out significant with a chance of "
        f"{shown} (1 − (1 − α)^{n} at α = {float(found['hypotheses.alpha']):g}, taking them as independent). "
    )


def _worst(tested: Hypotheses, scale: ActivityScale) -> str:
    if np.isnan(tested.worst_p):
        return f"No pair among {listed(tested.kept)} could be tested."
    pairs, (row, pair) = tested.tests.pairs, tested.worst
    verdict = "all pairs differ" if tested.worst_p < tested.alpha else "not all pairs differ"
    holm, lsd = p_text(float(pairs.p_holm[row, pair])), pairs.lsd
    low, high = (number(float(end[row, pair]) * scale.factor) for end in (lsd.low, lsd.high))
    by = f"{activity(float(lsd.difference[row, pair]), scale)}, {100 * lsd.confidence:g}% CI [{low}, {high}]"
    return (
        f"Largest p of Fisher's LSD among them: {tested.worst_pair}, {statistic_said(lsd.outcome(row, pair))}, by {by};"
        f" {verdict} at this level. With Holm's correction over the pairs of that participant: {holm}."
    )


def _power(tables: Mapping[str, Table]) -> str:
    return (
        html.heading("Was the sample large enough?")
        + html.paragraph("Claim: 14 participants with ten movements give a power of .80 at f = 0.25 and α = .05.")
        + tables["verdict_power"].html()
        + html.paragraph(MEANING)
        + html.details("If correlation and sphericity were otherwise", tables["power_sensitivity"].html())
    )
