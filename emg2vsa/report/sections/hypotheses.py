"""The tests of section IV.B: Gaussian clusters, equal participants, different specimens, their pairs."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.special import stdtrit

from emg2vsa.arrays import Floats
from emg2vsa.companions.groups import GroupTests
from emg2vsa.figures.cocontraction import draw_mixed_residuals
from emg2vsa.hypotheses import Hypotheses
from emg2vsa.report.companion_rows import pair_names
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, fields_of, least, most, named, with_interval
from emg2vsa.report.section import Quantities, Section, of_people
from emg2vsa.report.sections.hypothesis_tables import hypothesis_tables
from emg2vsa.report.wording import UNDEFINED, number, signed
from emg2vsa.statistics.clusters import Names
from emg2vsa.statistics.mixed import MixedModel
from emg2vsa.statistics.mixed_variances import SOURCES
from emg2vsa.statistics.studentized_range import survival
from emg2vsa.statistics.trend import trend


def _quantities(results: StudyResults) -> Items:
    if (found := results.recorded.hypotheses) is None:
        return
    yield from named("hypotheses", kept=", ".join(found.kept), order=found.drift.order)
    yield from fields_of("hypotheses", found, "alpha", "worst_p", "worst_pair")
    yield "hypotheses.normality.clusters", int(np.count_nonzero(found.count))
    for kind in ("standardised", "raw", "lilliefors", "shapiro"):
        yield from _family(f"hypotheses.normality.{kind}", getattr(found.tests.normality, kind).p, found.alpha)
    yield from _design_quantities("between_participants", found.specimens, found.tests.between_blocks, found.alpha)
    yield from _design_quantities("between_specimens", found.participants, found.tests.between_groups, found.alpha)
    yield from _pair_quantities(found)
    yield from _over_people_quantities(found, results.activity_suffix)
    yield from _stiffness_quantities(results)
    b_v = results.recorded.fits.b_v[results.used]
    level = float(np.mean(b_v)) if b_v.size else 0.0
    over = 100 * (found.drift.places - 1) / level if level and found.drift.places > 1 else np.nan
    for kind, slope in (("by_order", found.drift.by_order), ("within_recordings", found.drift.within)):
        of = slope.times(over)
        yield from with_interval(f"hypotheses.drift.{kind}_percent", of.value, *of.interval(1 - found.alpha))


def _stiffness_quantities(results: StudyResults) -> Items:
    """Does b rise with stiffness? One slope of b over ln stiffness a participant, and Student's t of these slopes."""
    fits, stiffness, used = results.recorded.fits, results.study.stiffness_n_per_mm, results.used
    log = np.array([np.log(stiffness.get(name, np.nan)) for name in fits.specimen[used].tolist()])
    one_group = np.zeros(log.size, dtype=np.str_)
    found = trend(fits.participant[used], one_group, log, fits.b_v[used])
    names = set(fits.specimen[used].tolist())
    by_mean = sorted(names, key=lambda name: np.mean(fits.b_v[used & (fits.specimen == name)]), reverse=True)
    yield "hypotheses.b_order", ", ".join(by_mean)
    yield from fields_of("hypotheses.b_over_log_stiffness", found, "t", "p")


def _design_quantities(name: str, designs: Names, tests: GroupTests, alpha: float) -> Items:
    name, anova = f"hypotheses.{name}", tests.anova
    yield from _family(name, anova.p, alpha)
    yield f"{name}.largest_p", most(anova.p)
    for kind in ("welch", "kruskal", "brown_forsythe"):
        yield f"{name}.{kind}.significant", _significant(getattr(tests, kind).p, alpha)
    for i, design in enumerate(designs[: anova.f.size].tolist()):
        yield from fields_of(f"{name}.{design}", anova, "f", "df1", "df2", "p", "eta2", at=i)
        yield from fields_of(f"{name}.{design}", tests, "omega2", "eta2_low", "eta2_high", at=i)
        yield from fields_of(f"{name}.{design}", tests.bayes, "bf01", at=i)


def _pair_quantities(found: Hypotheses) -> Items:
    pairs, name = found.tests.pairs, "hypotheses.pairs"
    yield from _family(name, pairs.lsd.p, found.alpha, _chance_of_any_pair(found))
    for kind, p in pairs.corrected.items():
        yield f"{name}.{kind}.significant", _significant(p, found.alpha)
        yield f"hypotheses.worst_p.{kind}", float(p[found.worst]) if found.worst[0] >= 0 else np.nan
    for i, participant in enumerate(found.participants[: len(pairs.lsd.p)].tolist()):
        for j, ends in enumerate(pair_names(found.specimens, pairs.lsd, "-") if found.specimens.size > 1 else ()):
            yield f"{name}.{participant}.{ends}.p", pairs.lsd.p[i, j].item()


def _over_people_quantities(found: Hypotheses, unit: str) -> Items:
    equality, blocks, name = found.tests.equality, found.tests.blocks, "hypotheses.over_people"
    slope, people = found.trend, found.people
    yield from named(
        "hypotheses.people", press_sd=people.press_sd, press_df=people.press_df, press_rho=people.press_rho
    )
    yield from with_interval(f"hypotheses.trend.b{unit}_per_repetition", slope.mean, slope.low, slope.high)
    yield from named("hypotheses.trend", relative_per_repetition=slope.per_mean, p=slope.p)
    yield "hypotheses.equality.bound_sd", most(equality.bound_sd)
    if equality.margin:
        shown, pairs = int(np.sum(equality.shown)), int(np.sum(equality.pairs))
        yield from named("hypotheses.equality", margin_sd=equality.margin, pairs_shown_equal=shown, pairs=pairs)
    if blocks is None:
        return
    of_means = ("f", "p", "p_gg", "p_hf", "epsilon_gg", "epsilon_hf", "mauchly_p", "eta2_generalised")
    yield from fields_of(f"{name}.repeated", blocks.repeated, *of_means, at=0)
    friedman, mixed = blocks.friedman.outcome(), blocks.mixed
    yield from named(f"{name}.friedman", chi2=friedman.statistic, p=friedman.p)
    if mixed is not None:
        yield from named(f"{name}.mixed", f=mixed.statistic, p=mixed.p, icc=mixed.effect_size)
    if isinstance(blocks.model, MixedModel):
        yield from fields_of(f"{name}.mixed", blocks.model, "sd_ratio", "ratio_low", "ratio_high")
    if (of := blocks.variances) is not None:
        for source, *sd in zip(SOURCES, of.sd, of.low, of.high, strict=True):
            yield from with_interval(f"{name}.mixed.sd_{source.replace(' ', '_')}{unit}", *sd)
    if blocks.residuals is not None:
        normal, level = blocks.residuals.outcomes()
        of_level = {"level_rho": level.effect_size, "level_p": level.p}
        yield from named(f"{name}.mixed.residuals", shapiro_p=normal.p, **of_level)
    for j, ends in enumerate(pair_names(found.specimens, blocks.paired.t, "-")):
        for test, p in blocks.pair_families.items():
            yield f"{name}.pairs.{ends}.{test.lower().replace(' ', '_').replace('-', '_')}.p_holm", p[0, j].item()
        yield from fields_of(f"{name}.pairs.{ends}", blocks.paired, "g", "g_low", "g_high", at=(0, j))


def _significant(p: Floats, alpha: float) -> int:
    return int(np.count_nonzero(p < alpha))


def _family(name: str, p: Floats, alpha: float, chance: float | None = None) -> Items:
    """``chance_of_any``: that of at least one rejection where nothing differs; without one, of independent tests."""
    tested = int(np.count_nonzero(np.isfinite(p)))
    chance = 1 - (1 - alpha) ** tested if chance is None else chance
    yield from named(name, tested=tested, significant=_significant(p, alpha), chance_of_any=chance, smallest_p=least(p))


def _chance_of_any_pair(found: Hypotheses) -> float:
    """Chance that Fisher's LSD without protection finds any pair, participants independent: the pairs of one share
    their means and their SD.

    All pairs of a participant stay below the critical t as long as the studentized range of his k groups does (exact
    for groups of one size, a little too many otherwise).
    """
    anova = found.tests.between_groups.anova
    tested = np.isfinite(anova.p) & (anova.df2 > 0)
    df1, df2 = anova.df1[tested], anova.df2[tested]
    some = survival(np.sqrt(2) * -stdtrit(df2, found.alpha / 2), df1 + 1, df2)
    return float(1 - np.prod(1 - some))


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    tested = results.recorded.hypotheses
    if not (tested and tested.tests.blocks and (found := tested.tests.blocks.residuals)):
        return
    least_sd, most_sd = (number(float(end)) for end in (found.residual.min(), found.residual.max()))
    far = np.count_nonzero(np.abs(found.residual) > 3)
    yield Drawing(
        "mixed_residuals",
        "Residuals of the mixed model",
        "Residuals of the mixed model, in SDs of repetitions: (a) against normal quantiles, where normal residuals lie "
        "near the dashed line; (b) against fitted b, where an equal scatter fills a band of one width.",
        f"{found.residual.size} residuals from {least_sd} to {most_sd} SDs of repetitions; {far} lie farther than 3 "
        "SDs from zero.",
        draw_mixed_residuals(found.fitted, found.residual, found.quantile, results.scale),
    )


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    if (found := results.recorded.hypotheses) is None:
        return {}
    trend = "t test over participants" if found.trend.over_blocks else "regression within one participant"
    orders = {"differs": "differs between people", "same": "is the same for all, or one of few"}
    order = orders.get(found.drift.order, "is not known")
    return {"tested": found, "drift": _drift(q), "order": order, "trend": trend}


def _drift(q: Quantities) -> str:
    """Drift by the order where the order tells it, else by the presses of recordings."""
    for kind, tell in (("by_order", "this order tells"), ("within_recordings", "the presses of recordings tell")):
        name = f"hypotheses.drift.{kind}_percent"
        mean, low, high = (signed(float(q[key]), "%") for key in (name, f"{name}.low", f"{name}.high"))
        if mean != UNDEFINED:
            return f"Over a session, b changes by {mean} [{low}, {high}], as {tell}."
    return "The data do not tell how much b changes over a session."


_TEXT = """
{% if tested is not defined %}
<p>{{ why_absent("hypotheses") }}</p>
{% else %}
<p>These tests on the slopes b take α = {{ tested.alpha }}, and none was chosen by the outcome of another. The verdicts
in the <a href="#claims">summary</a> follow from intervals over people, not from these tests.</p>
<p>The order of specimens {{ order }}. {{ drift }}</p>
{{ folded("verdict_normality", "Are the clusters Gaussian? Tests compared") }}
{{ folded("normality", "Normality of every cluster") }}
{{ folded("verdict_participants", "Are the participants equal? Tests compared") }}
{{ folded("anova_participants", "ANOVA of every specimen") }}
{{ folded("verdict_specimens", "Do the specimens differ? Tests compared") }}
{{ folded("anova_specimens", "ANOVA of every participant") }}
{{ folded("verdict_pairs", "Which specimens differ? Tests compared") }}
{{ folded("lsd_pairs", "Every pair of specimens of every participant") }}
{% if has("mixed_residuals") %}
<p>The mixed model assumes normal residuals with one scatter at every level; the tests of these assumptions give
{{ q["hypotheses.over_people.mixed.residuals.shapiro_p"] | p }} and
{{ q["hypotheses.over_people.mixed.residuals.level_p"] | p }}.</p>
{{ folded("mixed_sd", "Scatter of b between people and between repetitions") }}
{{ folded("person_slopes", "b of each person, alone and in the hierarchy of the study") }}
{{ folded("mixed_residuals", "Residuals of the mixed model") }}
{% endif %}
{% if tested.trend.p == tested.trend.p %}
<p>From one repetition to the next, b changes by {{ tested.trend.per_mean | percent(2) }} of its mean
({{ tested.trend.p | p }}; {{ trend }}).</p>
{{ folded("trend", "Trend of every participant") }}
{% endif %}
{{ folded("statements", "Every result as APA, IEEE, LaTeX and plain text") }}
{% if tested.notes %}
<details><summary>Notes on the tests</summary>
{{ tested.notes | bullets }}
</details>
{% endif %}
{% endif %}
"""

HYPOTHESES = Section(
    "hypotheses", "Tests of the slopes b", _TEXT, of_people, _quantities, hypothesis_tables, _drawings, _words
)
