"""Co-contraction against force: Fig. 4, the fits v = a + b ln F, and whether they find the truth of a simulation."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations, pairwise

import numpy as np

from emg2vsa.companions.force_laws import LAWS, LEFT_OUT, ForceLaws
from emg2vsa.companions.law_misfit import MATTERS, LawMisfits
from emg2vsa.figures.canvas import PairBar
from emg2vsa.figures.cocontraction import draw_cocontraction
from emg2vsa.figures.palette import looks
from emg2vsa.hypotheses import Hypotheses
from emg2vsa.profiles import Unit, mean_errors
from emg2vsa.report import table
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, fields_of, least, median, moments, named, with_interval
from emg2vsa.report.section import Quantities, Section, of_people
from emg2vsa.report.table import Column, Columns, Table, activity_column, columns, from_quantities, table_of
from emg2vsa.report.wording import activity, count, p_text
from emg2vsa.shown import words_of
from emg2vsa.truth import Recovery, recover

_R2 = {
    "adj_r2": "adj. R², this fit", "r2_bins": "R², bins", "adj_r2_bins": "adj. R², bins", "r2_samples": "R², samples",
    "adj_r2_samples": "adj. R², samples",
}  # fmt: skip


def _quantities(results: StudyResults) -> Items:
    people, used, v = results.recorded, results.used, results.activity_suffix
    fits = people.fits
    yield from named("trials", total=fits.verdict.size, **people.verdict_counts())
    if people.trials:
        yield "trials.largest_delay_mismatch_s", max(abs(t.delay.mismatch_s) for t in people.trials)
    counts = {"curves": np.isfinite(fits.b_v), "used": used, "b_not_positive": fits.b_v[used] <= 0}
    yield from named("fit", **{key: int(np.count_nonzero(of)) for key, of in counts.items()})
    yield from fields_of("fit", fits, "points", "weights", "confidence", "activity_unit")
    for name in (*_R2, "n_effective", "lag1"):
        if name in _R2:
            yield f"fit.{name}.min", least(getattr(fits, name)[used])
        yield f"fit.{name}.median", median(getattr(fits, name)[used])
    half = _half_widths(results)
    for specimen in results.specimens:
        of = used & (fits.specimen == specimen)
        yield f"fit.{specimen}.n", int(np.count_nonzero(of))
        yield from moments(f"fit.{specimen}.a{v}", fits.a_v[of])
        yield from moments(f"fit.{specimen}.b{v}", fits.b_v[of])
        if specimen in half:
            mean = float(np.mean(fits.b_v[of]))
            yield f"fit.{specimen}.b{v}.low", mean - half[specimen]
            yield f"fit.{specimen}.b{v}.high", mean + half[specimen]
    if people.truth is not None and fits.activity_unit == "V":
        for of in (None, *results.specimens):
            recovery = recover(fits, people.truth, results.study.hypotheses.use, of)
            yield from fields_of(f"recovery.{of}" if of else "recovery", recovery, *vars(recovery))
    if people.hypotheses is not None:
        yield from _laws(people.hypotheses.laws)
        yield from _misfits(people.hypotheses.misfits)


def _half_widths(results: StudyResults) -> dict[str, float]:
    """Specimen to half of the interval of its mean b: over people, or over the presses of one person."""
    fits, used = results.recorded.fits, results.used
    pressed = [name for name in results.specimens if np.any(used & (fits.specimen == name))]
    if not pressed:
        return {}
    errors = mean_errors(fits, used, pressed, _unit(results), presses_weigh=True)
    return dict(zip(pressed, errors.half_width(np.eye(len(pressed))[:, :, None] * [0.0, 1.0]).tolist(), strict=True))


def _unit(results: StudyResults) -> Unit:
    return "person" if np.unique(results.recorded.fits.participant[results.used]).size > 1 else "press"


def _laws(laws: ForceLaws) -> Items:
    """Power law and straight line beside the logarithm, by errors of prediction."""
    for kind, left_out in enumerate(LEFT_OUT):
        name = f"fit.laws.leave_one_{left_out}_out"
        yield f"{name}.cells", int(laws.compared[kind])
        for i, law in enumerate(LAWS):
            yield f"{name}.{law}.relative_error", median(laws.error[kind, i])
            if i:
                ratio = (laws.ratio, laws.ratio_low, laws.ratio_high)
                yield from with_interval(f"{name}.{law}.error_ratio", *(end[kind, i] for end in ratio))
                better = int(laws.better[kind, i])
                yield from named(f"{name}.{law}", p=float(laws.p[kind, i]), better_cells=better)


def _misfits(misfits: LawMisfits) -> Items:
    """Distance of the presses of all people from each law, shares of the level."""
    for law, found in zip(LAWS, misfits.together, strict=True):
        name = f"fit.laws.{law}"
        yield from with_interval(f"{name}.distance", found.share, found.low, found.high)
        yield from named(name, distance_p=found.p, people_off=int(np.count_nonzero(_off(misfits, LAWS.index(law)))))


def _off(misfits: LawMisfits, law: int) -> list[bool]:
    """For each person, whether the law does not fit."""
    return [misfits.of(law, person).told for person in range(misfits.participant.size)]


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    yield _every(results)
    yield _by_specimen(results, q)
    if "recovery.n" in q:
        yield _recovery(results, q)
    if results.recorded.hypotheses is not None:
        yield _laws_table(results.recorded.hypotheses.laws)
        yield _misfits_table(results, results.recorded.hypotheses.misfits)


def _misfits_table(results: StudyResults, misfits: LawMisfits) -> Table:
    people, scale, level = misfits.participant.size, results.scale, 100 * (1 - results.study.hypotheses.alpha)
    person, law = (index.ravel() for index in np.indices((people, len(LAWS))))
    places = zip(law.tolist(), person.tolist(), strict=True)
    found: Columns = {
        Column("participant", "Participant"): misfits.participant[person],
        Column("presses", "Presses"): misfits.presses[person],
        Column("law", "Law of v(F)"): [LAWS[i] for i in law],
        **columns(misfits, "share", "low", "high", "p", at=(law, person)),
        activity_column("rms_v", "Distance", scale): misfits.share[law, person] * misfits.level_v[person],
        Column("fits", "Fits"): ["no" if misfits.of(*at).told else "" for at in places],
        Column("largest", "Spline less logarithm, largest (% of level)", 100.0): np.where(
            law == 0, misfits.largest[person], np.nan
        ),
        Column("at_n", "at (N)"): np.where(law == 0, misfits.at_n[person], np.nan),
    }
    caption = (
        "Distance of a person's presses from each law: root mean square over the range of force of the three smoothest "
        f"shapes that the law cannot take, with its {level:g} % interval over presses. It does not fit where the low "
        f"end is above {100 * MATTERS:g} %; p is that of no distance at all"
    )
    return table_of("law_misfits", caption, found, table.FEW_ON_PAGE)


def _laws_table(laws: ForceLaws) -> Table:
    some = np.repeat(laws.compared[:, None] > 0, len(LAWS), axis=1)
    kind, law = np.nonzero(some)
    found: Columns = {
        Column("left_out", "Left out"): [f"one {LEFT_OUT[k]}" for k in kind],
        Column("law", "Law of v(F)"): [LAWS[i] for i in law],
        Column("relative_error", "Median error of prediction (%)", 100.0): [median(of) for of in laws.error[some]],
        **columns(laws, "ratio", "ratio_low", "ratio_high", "p", at=some),
        Column("better", "Better in"): [int(n) if i else None for n, i in zip(laws.better[some], law, strict=True)],
        Column("compared", "of cells"): laws.compared[kind],
    }
    caption = "Logarithm, power law and straight line for v(F): errors in predicting what was left out of the fit"
    return table_of("force_laws", caption, found)


def _every(results: StudyResults) -> Table:
    fits, scale = results.recorded.fits, results.scale
    heads = {
        "participant": "Participant", "specimen": "Specimen", "repetition": "Press", "verdict": "Verdict", "a_v": "a",
        "b_v": "b", "a_se_v": "SE a", "b_se_v": "SE b", "b_lo_v": "b low", "b_hi_v": "b high", "n_points": "Points",
        **_R2, "n_effective": "n effective", "lag1": "lag-1", "start_s": "Start (s)", "reason": "Reason",
    }  # fmt: skip
    values = {
        activity_column(key, head, scale) if key.endswith("_v") else Column(key, head): getattr(fits, key)
        for key, head in heads.items()
    }
    return table_of("fits", "All trials, rejected ones included: fit v = a + b ln F", values, table.FEW_ON_PAGE)


def _by_specimen(results: StudyResults, q: Quantities) -> Table:
    fits, scale, specimens, v = results.recorded.fits, results.scale, results.study.specimens, results.activity_suffix
    every = [fits.specimen == specimen.name for specimen in specimens]
    found: Columns = {
        Column("specimen", "Specimen"): results.specimens,
        Column("stiffness_n_per_mm", "Stiffness κ (N/mm)"): [specimen.stiffness_n_per_mm for specimen in specimens],
        Column("trials", "Trials"): np.count_nonzero(every, axis=1),
        **from_quantities(q, [f"fit.{specimen}" for specimen in results.specimens], {
            Column("used", "Used"): "n",
            activity_column("a_mean_v", "Mean a", scale): f"a{v}.mean",
            activity_column("b_mean_v", "Mean b", scale): f"b{v}.mean",
            activity_column("b_low_v", "Low", scale): f"b{v}.low",
            activity_column("b_high_v", "High", scale): f"b{v}.high",
            activity_column("b_sd_v", "SD b", scale): f"b{v}.sd",
        }),
    }  # fmt: skip
    for key in ("adj_r2_bins", "adj_r2_samples"):
        used = [getattr(fits, key)[results.used & of] for of in every]
        found[Column(f"{key}_min", f"Worst {_R2[key]}")] = list(map(least, used))
        found[Column(f"{key}_median", f"Median {_R2[key]}")] = list(map(median, used))
    caption = (
        "Fits v = a + b ln F of the trials used, by specimen. Low and high: interval of the mean b over "
        f"{'people' if _unit(results) == 'person' else 'presses'}, {100 * fits.confidence:g} %. Smoother points give a "
        "larger R² from the same trial, so force bins and samples have an R² each"
    )
    return table_of("fits_by_specimen", caption, found)


def _recovery(results: StudyResults, q: Quantities) -> Table:
    names: Columns = {Column("specimen", "Specimen"): ("all", *results.specimens)}
    keys = {Column(key, *words): key for key, words in words_of(Recovery).items()}
    found = from_quantities(q, ["recovery", *(f"recovery.{name}" for name in results.specimens)], keys)
    return table_of("recovery", "Fitted slopes beside the true slopes of the simulation", names | found)


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    """Fig. 4: of the exported specimens among which the worst p was taken, or all exported where that leaves none."""
    exported, tested, scale = results.recorded.profiles, results.recorded.hypotheses, results.scale
    if exported is None:
        return
    whose = exported.participant
    profiles = [p for p in exported.profiles if tested and p.specimen in tested.kept] or exported.profiles
    names = [profile.specimen for profile in profiles]
    fits, look = results.recorded.fits, looks(results.specimens)
    own = results.used & np.isin(fits.participant, whose or fits.participant)
    slopes = [np.asarray(fits.b_v[own & (fits.specimen == name)]) for name in names]
    bars = _bars(tested, names, whose) if tested else []
    test = "Fisher's LSD" + ("" if whose else ", largest p of all participants")
    figure = draw_cocontraction(profiles, slopes, bars, [look[name] for name in names], scale, test)
    caption = (
        f"Fig. 4. Co-contraction of {whose or 'all participants'}. (a) Mean fitted trends; bands are one SD between "
        f"{'trials' if whose else 'participants'}. (b) Slopes b of trials with Hazen's quartiles."
        + (" Stars: p of the uncorrected LSD below .05, .01, .001, .0001." if bars else "")
    )
    pairs = "; ".join(f"{names[bar.first]} and {names[bar.second]}: {p_text(bar.p)}" for bar in bars)
    told = [
        f"{p.specimen}: {activity(p.v[0], scale)} to {activity(p.v[-1], scale)}, median b "
        f"{activity(float(np.median(b)), scale) if b.size else 'not known'} in {count(b.size, 'trial')}"
        for p, b in zip(profiles, slopes, strict=True)
    ]
    description = "; ".join(told) + (f". {test}: {pairs}" if pairs else "") + "."
    title = "Co-contraction against force, and slopes b by specimen"
    yield Drawing("fig04_cocontraction", title, caption, description, figure)


def _bars(hypotheses: Hypotheses, names: Sequence[str], whose: str) -> list[PairBar]:
    """All pairs of up to four specimens, neighbours of more."""
    lsd, places, bars = hypotheses.tests.pairs.lsd, range(len(names)), []
    own = np.isin(hypotheses.participants[: len(lsd.p)], whose or hypotheses.participants)
    for first, second in combinations(places, 2) if len(names) <= 4 else pairwise(places):
        ends = np.isin(hypotheses.specimens, [names[first], names[second]])
        these = lsd.p[own][:, ends[lsd.first] & ends[lsd.second]]
        if np.isfinite(these).any():
            bars.append(PairBar(first, second, float(np.nanmax(these))))
    return bars


_TEXT = """
{{ figure("fig04_cocontraction") }}
<p>The median adj. R² of a trial is {{ q['fit.adj_r2_bins.median'] | bounded }} on force bins and
{{ q['fit.adj_r2_samples.median'] | bounded }} on samples. The correlated samples of a trial carry as much information
as about {{ q['fit.n_effective.median'] | number(2) }} independent ones.
{% if q['fit.b_not_positive'] %}
The slope of {{ q['fit.b_not_positive'] | count("used trial") }} is not positive.
{% endif %}</p>
{{ folded("fits_by_specimen", "Fits by specimen") }}
{{ folded("fits", "Every trial, rejected ones included") }}
{{ folded("force_laws", "Other laws of force: power and straight line") }}
{{ folded("law_misfits", "Distance of each person's presses from the three laws") }}
{% if 'recovery.n' in q %}
<p>The simulated curves follow v = a + b ln F, as the fits do. The fitted slopes miss the true ones by
{{ q['recovery.mean_b_error'] | percent(2) }} on average, and {{ q['recovery.coverage'] | percent(3) }} of the
{{ q['recovery.confidence'] | percent(2) }} intervals hold the true slope.</p>
{{ folded("recovery", "Fitted and true slopes by specimen") }}
{% elif people.truth %}
<p>The activity is normalised and the simulated truth is in volts, so they cannot be compared.</p>
{% endif %}
"""

FITS = Section("fits", "Co-contraction against force", _TEXT, of_people, _quantities, _tables, _drawings)
