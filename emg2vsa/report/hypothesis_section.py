"""The tests of section IV.B in plain words: the claim, the paper's test by name, what came out, what to mind."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

import numpy as np

from emg2vsa.hypotheses import Hypotheses
from emg2vsa.report import html
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.quantities import Quantity
from emg2vsa.report.table import Table
from emg2vsa.report.wording import NO_BREAK, bounded, f_text, listed, number, p_text, percent, t_text
from emg2vsa.stats.ks_exact import ks_survival


def hypotheses(results: StudyResults, found: Mapping[str, Quantity], tables: Mapping[str, Table]) -> str:
    """All four: Gaussian clusters, equal participants, different specimens, power."""
    title = "Hypotheses"
    tested = results.hypotheses
    if tested is None:
        return html.section("hypotheses", title, html.paragraph(results.why_absent("hypotheses")))
    return html.section(
        "hypotheses",
        title,
        html.paragraph(f"All tests are on the slopes b, at alpha = {tested.alpha:g}."),
        _normality(tested, found, tables),
        _between_participants(tested, found, tables),
        _between_specimens(tested, found, tables),
        _power(tested, found),
        html.heading("Notes of the tests") + html.bullets(tested.notes) if tested.notes else "",
    )


def _claim(title: str, claim: str, test: str, result: str, mind: str, table: str = "") -> str:
    items = {"Claim": claim, "Test": test, "Result": result, "Mind": mind}
    entries = "".join(f"<dt>{name}</dt><dd>{escape(text)}</dd>" for name, text in items.items())
    return f"{html.heading(title)}<dl>{entries}</dl>\n{table}"


def _normality(tested: Hypotheses, found: Mapping[str, Quantity], tables: Mapping[str, Table]) -> str:
    key = "hypotheses.normality"
    if found[f"{key}.raw.tested"]:
        parts = {kind: _deviating(found, f"{key}.{kind}") for kind in ("standardised", "raw")}
        result = f"Standardised: {parts['standardised']}. Raw: {parts['raw']}."
    else:
        result = "There is no cluster to test."
    return _claim(
        "Is each cluster Gaussian?",
        "The slopes of one participant on one specimen come from a Gaussian distribution.",
        "One-sample Kolmogorov-Smirnov, in the two ways that go by this name: on values standardised by their own mean "
        "and standard deviation, and on raw values against N(0, 1), the default of MATLAB's kstest. The paper does not "
        "say which; only the first can give its answer, since b is positive.",
        result,
        "Standardising by the sample's own mean and standard deviation makes p far too large, so passing says next to "
        f"nothing about shape. {_raw_bound(tested)}",
        html.details("Every cluster", tables["normality"].html()),
    )


def _raw_bound(tested: Hypotheses) -> str:
    """How little the raw test looks at the shape of positive values, from the sizes of the clusters at hand."""
    sizes = tested.normality.n[np.isfinite(tested.normality.p_raw)]
    bounds = [
        f"at most {bounded(p, 4)} for {n} values"
        for n in sorted({int(np.min(sizes)), int(np.max(sizes))} if sizes.size else ())
        for p in ks_survival([0.5], [n]).tolist()
    ]
    at = f", and p is {' and '.join(bounds)}, whatever their shape" if bounds else ""
    return f"Positive values have D of .5 or more in the raw test{at}."


def _deviating(found: Mapping[str, Quantity], test: str) -> str:
    if not found[f"{test}.tested"]:
        return "no cluster is large enough"
    smallest = p_text(float(found[f"{test}.smallest_p"]))
    return f"{found[f'{test}.significant']} of {found[f'{test}.tested']} clusters deviate (smallest {smallest})"


def _between_participants(tested: Hypotheses, found: Mapping[str, Quantity], tables: Mapping[str, Table]) -> str:
    anova, key = tested.between_participants, "hypotheses.between_participants"
    if found[f"{key}.tested"]:
        worst = int(np.nanargmin(anova.p))
        said = f_text(*(float(getattr(anova, name)[worst]) for name in ("f", "df1", "df2", "p", "eta2")))
        result = (
            f"Participants differ significantly for {found[f'{key}.significant']} of {found[f'{key}.tested']} "
            f"specimens. Smallest p: {anova.specimen[worst]}, {said}."
        )
    else:
        result = "Not tested: this takes usable trials of two participants or more."
    return _claim(
        "Do participants differ?",
        "People palpate the same specimen with the same slope.",
        "One-way ANOVA between participants, one for each specimen.",
        result,
        _chance(found, key, "tests")
        + "A test that finds no difference does not show that there is none: it only bounds how large a difference "
        "could have been missed.",
        tables["anova_participants"].html() if found[f"{key}.tested"] else "",
    )


def _between_specimens(tested: Hypotheses, found: Mapping[str, Quantity], tables: Mapping[str, Table]) -> str:
    key, shown = "hypotheses.between_specimens", ""
    if found[f"{key}.tested"]:
        result = (
            f"Specimens differ significantly for {found[f'{key}.significant']} of {found[f'{key}.tested']} "
            f"participants. {_worst(tested)}"
        )
        shown = html.details("ANOVA of every participant", tables["anova_specimens"].html())
        shown += html.details(f"All {tested.pairs.p.size} pairs", tables["lsd_pairs"].html())
    else:
        result = "Not tested: this takes usable trials on two specimens or more."
    return _claim(
        "Do specimens differ?",
        f"For every participant, {listed(tested.kept)} have different slopes.",
        "One-way ANOVA between specimens, one for each participant, then Fisher's LSD: pairwise t tests with the "
        "pooled standard deviation, not corrected for the number of pairs.",
        result,
        _chance(found, "hypotheses.pairs", "uncorrected pairs")
        + "Repetitions of one person count as independent here, so each ANOVA speaks of that person only, not of "
        "people.",
        shown,
    )


def _chance(found: Mapping[str, Quantity], key: str, many: str) -> str:
    """What a family of tests rejects by chance alone."""
    if not (n := int(found[f"{key}.tested"])):
        return ""
    chance = float(found[f"{key}.chance_of_any"])
    shown = f"more than 99.9{NO_BREAK}%" if chance > 0.999 else percent(chance)
    return (
        f"If nothing differed at all, at least one of {n} {many} would come out significant with a chance of "
        f"{shown} (1 − (1 − α)^{n} at α = {float(found['hypotheses.alpha']):g}, taking them as independent). "
        if n > 1
        else ""
    )


def _worst(tested: Hypotheses) -> str:
    if np.isnan(tested.worst_p):
        return f"No pair among {listed(tested.kept)} could be tested."
    pairs = tested.pairs
    among = np.isin(pairs.first, tested.kept) & np.isin(pairs.second, tested.kept) & np.isfinite(pairs.p)
    i = int(np.argmax(np.where(among, pairs.p, -1.0)))
    verdict = "all pairs differ" if tested.worst_p < tested.alpha else "not all pairs differ"
    return (
        f"Worst pair among {listed(tested.kept)}, over all participants: {tested.worst_pair}, "
        f"{t_text(float(pairs.t[i]), float(pairs.df[i]), tested.worst_p)}; {verdict} at this level."
    )


def _power(tested: Hypotheses, found: Mapping[str, Quantity]) -> str:
    study = "not defined" if np.isnan(tested.power) else number(tested.power)
    return _claim(
        "Was the sample large enough?",
        "Fourteen participants with ten movements give a power of about .80 at f = 0.25 and alpha = 0.05.",
        "Repeated-measures F test within factors, noncentral F, with the correlation .5 and sphericity 1 that G*Power "
        "proposes.",
        f"Power of the paper's design: {number(float(found['power.n14']))}. Power of this study's design: {study}.",
        "With ten repetitions entered as measurements this is the power to tell repetitions apart; neither comparison "
        "above was planned for.",
    )
