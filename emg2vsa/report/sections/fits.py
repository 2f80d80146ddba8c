"""The fits v = a + b ln F: how many, how good, and whether they find the truth that a simulation was made from."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.companions.force_laws import LAWS, LEFT_OUT, ForceLaws
from emg2vsa.profiles import Unit, mean_errors
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, fields_of, least, moments, with_interval
from emg2vsa.report.section import Quantities, Section, of_people
from emg2vsa.report.table import Column, Columns, Table, activity_column, table_of
from emg2vsa.truth import Recovery, recover

_R2 = {
    "adj_r2": "adj. R²", "r2_bins": "R², bins", "adj_r2_bins": "adj. R², bins", "r2_samples": "R², samples",
    "adj_r2_samples": "adj. R², samples",
}  # fmt: skip


def _quantities(results: StudyResults) -> Items:
    people, used = results.recorded, results.used
    fits = people.fits
    yield "trials.total", int(fits.verdict.size)
    for verdict, n in people.verdict_counts().items():
        yield f"trials.{verdict}", n
    if people.trials:
        yield "trials.largest_delay_mismatch_s", max(abs(t.delay.mismatch_s) for t in people.trials)
    yield "fit.curves", int(np.count_nonzero(np.isfinite(fits.b_v)))
    yield "fit.used", int(np.count_nonzero(used))
    yield from fields_of("fit", fits, "points", "weights", "confidence", "activity_unit")
    yield "fit.b_not_positive", int(np.count_nonzero(fits.b_v[used] <= 0))
    for name in _R2:
        values = getattr(fits, name)[used]
        yield f"fit.{name}.min", least(values)
        yield f"fit.{name}.median", _median(values)
    yield "fit.n_effective.median", _median(fits.n_effective[used])
    yield "fit.lag1.median", _median(fits.lag1[used])
    for specimen in results.specimens:
        of = used & (fits.specimen == specimen)
        yield f"fit.{specimen}.n", int(np.count_nonzero(of))
        yield from moments(f"fit.{specimen}.a{results.activity_suffix}", fits.a_v[of])
        yield from moments(f"fit.{specimen}.b{results.activity_suffix}", fits.b_v[of])
    for specimen, (low, high) in _means_of_b(results).items():
        yield f"fit.{specimen}.b{results.activity_suffix}.low", low
        yield f"fit.{specimen}.b{results.activity_suffix}.high", high
    if people.truth is not None and fits.activity_unit == "V":
        for specimen, recovery in _recoveries(results):
            yield from fields_of(f"recovery.{specimen}".rstrip("."), recovery, *vars(recovery))
    if people.hypotheses is not None:
        yield from _laws(people.hypotheses.laws)


def _means_of_b(results: StudyResults) -> dict[str, tuple[float, float]]:
    """Specimen to the interval of its mean b: over people, or over the presses of one person."""
    fits, used = results.recorded.fits, results.used
    pressed = [name for name in results.specimens if np.any(used & (fits.specimen == name))]
    if not pressed:
        return {}
    errors = mean_errors(fits, used, pressed, _unit(results), presses_weigh=True)
    half = errors.half_width(np.eye(len(pressed))[:, :, None] * [0.0, 1.0])
    means = [float(np.mean(fits.b_v[used & (fits.specimen == name)])) for name in pressed]
    return {name: (b - h, b + h) for name, b, h in zip(pressed, means, half.tolist(), strict=True)}


def _unit(results: StudyResults) -> Unit:
    return "person" if np.unique(results.recorded.fits.participant[results.used]).size > 1 else "press"


def _laws(laws: ForceLaws) -> Items:
    """Power law and straight line beside the logarithm, by errors of prediction."""
    for kind, left_out in enumerate(LEFT_OUT):
        name = f"fit.laws.leave_one_{left_out}_out"
        yield f"{name}.cells", int(laws.compared[kind])
        for i, law in enumerate(LAWS):
            yield f"{name}.{law}.relative_error", _median(laws.error[kind, i])
            if i:
                ratio = (laws.ratio, laws.ratio_low, laws.ratio_high)
                yield from with_interval(f"{name}.{law}.error_ratio", *(end[kind, i] for end in ratio))
                yield f"{name}.{law}.p", float(laws.p[kind, i])
                yield f"{name}.{law}.better_cells", int(laws.better[kind, i])


def _median(values: Floats) -> float:
    return float(np.nanmedian(values)) if np.isfinite(values).any() else np.nan


def _recoveries(results: StudyResults) -> Iterator[tuple[str, Recovery]]:
    """Of all specimens together (""), then of each."""
    fits, truth = results.recorded.fits, results.recorded.truth
    assert truth is not None
    for name in ("", *results.specimens):
        yield name, recover(fits, truth, results.study.hypotheses.use, name or None)


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    yield _every(results)
    yield _by_specimen(results)
    if results.recorded.truth is not None:
        yield _recovery(results)
    if results.recorded.hypotheses is not None:
        yield _laws_table(results.recorded.hypotheses.laws)


def _laws_table(laws: ForceLaws) -> Table:
    cells = [(kind, i) for kind in range(len(LEFT_OUT)) for i in range(len(LAWS)) if laws.compared[kind]]
    columns: Columns = {
        Column("left_out", "Left out"): [f"one {LEFT_OUT[kind]}" for kind, _ in cells],
        Column("law", "Law of v(F)"): [LAWS[i] for _, i in cells],
        Column("relative_error", "Median error of prediction (%)", 100.0): [_median(laws.error[at]) for at in cells],
        Column("ratio", "Over the logarithm's"): [float(laws.ratio[at]) for at in cells],
        Column("ratio_low", "Low"): [float(laws.ratio_low[at]) for at in cells],
        Column("ratio_high", "High"): [float(laws.ratio_high[at]) for at in cells],
        Column("p", "p"): [float(laws.p[at]) if at[1] else None for at in cells],
        Column("better", "Better in"): [int(laws.better[at]) if at[1] else None for at in cells],
        Column("compared", "of cells"): [int(laws.compared[kind]) for kind, _ in cells],
    }
    caption = "Logarithm, power law and straight line for v(F): errors in predicting what was left out of the fit"
    return table_of("force_laws", caption, columns)


def _every(results: StudyResults) -> Table:
    fits, scale = results.recorded.fits, results.scale
    texts = {"participant": "Participant", "specimen": "Specimen", "repetition": "Press", "verdict": "Verdict"}
    activities = {"a_v": "a", "b_v": "b", "a_se_v": "SE a", "b_se_v": "SE b", "b_lo_v": "b low", "b_hi_v": "b high"}
    others = {"n_points": "Points", **_R2, "n_effective": "n effective", "lag1": "lag-1", "start_s": "Start (s)"}
    columns = (
        *(Column(key, head) for key, head in texts.items()),
        *(activity_column(key, head, scale) for key, head in activities.items()),
        *(Column(key, head) for key, head in (others | {"reason": "Reason"}).items()),
    )
    values = {column: getattr(fits, column.key) for column in columns}
    return table_of("fits", "All trials, rejected ones included: fit v = a + b ln F", values)


def _by_specimen(results: StudyResults) -> Table:
    fits, scale, specimens = results.recorded.fits, results.scale, results.study.specimens
    every = [fits.specimen == specimen.name for specimen in specimens]
    interval: dict[str, tuple[float | None, float | None]] = {**_means_of_b(results)}
    used = [results.used & of for of in every]

    def over(statistic: Callable[[Floats], Any], values: Floats, least: int = 1) -> list[float | None]:
        return [float(statistic(values[of])) if np.count_nonzero(of) >= least else None for of in used]

    columns: Columns = {
        Column("specimen", "Specimen"): results.specimens,
        Column("stiffness_n_per_mm", "Stiffness κ (N/mm)"): [specimen.stiffness_n_per_mm for specimen in specimens],
        Column("trials", "Trials"): [int(np.count_nonzero(of)) for of in every],
        Column("used", "Used"): [int(np.count_nonzero(of)) for of in used],
        activity_column("a_mean_v", "Mean a", scale): over(np.mean, fits.a_v),
        activity_column("b_mean_v", "Mean b", scale): over(np.mean, fits.b_v),
        activity_column("b_low_v", "Low", scale): [interval.get(name, (None, None))[0] for name in results.specimens],
        activity_column("b_high_v", "High", scale): [interval.get(name, (None, None))[1] for name in results.specimens],
        activity_column("b_sd_v", "SD b", scale): over(partial(np.std, ddof=1), fits.b_v, 2),
        Column("adj_r2_bins_min", "Worst adj. R², bins"): over(np.min, fits.adj_r2_bins),
        Column("adj_r2_bins_median", "Median adj. R², bins"): over(np.median, fits.adj_r2_bins),
        Column("adj_r2_samples_min", "Worst adj. R², samples"): over(np.min, fits.adj_r2_samples),
        Column("adj_r2_samples_median", "Median adj. R², samples"): over(np.median, fits.adj_r2_samples),
    }
    over_what = "people" if _unit(results) == "person" else "presses"
    caption = (
        "Fits v = a + b ln F of the trials used, by specimen; low and high: interval of the mean b over "
        f"{over_what}, {100 * fits.confidence:g} %"
    )
    return table_of("fits_by_specimen", caption, columns)


def _recovery(results: StudyResults) -> Table:
    every = list(_recoveries(results))
    columns = (
        Column("n", "Trials"), Column("mean_b_error", "Mean error of b (%)", 100.0),
        Column("mean_b_error_mcse", "Monte-Carlo SE (%)", 100.0, 2),
        Column("sd_b_error", "SD of the error of b (%)", 100.0),
        Column("coverage", "Intervals that hold the true b (%)", 100.0),
        Column("coverage_mcse", "Monte-Carlo SE (%)", 100.0, 2),
    )  # fmt: skip
    found = {column: [getattr(each, column.key) for _, each in every] for column in columns}
    names = {Column("specimen", "Specimen"): [name or "all" for name, _ in every]}
    return table_of("recovery", "Fitted slopes beside the true slopes of the simulation", names | found)


_TEXT = """
<p>Smoother points give a larger R² from the same trial, so R² on force bins and on samples are shown apart.
Neighbouring samples are correlated: a trial carries as much information as about
{{ q['fit.n_effective.median'] | number(2) }} independent samples.</p>
{{ folded("fits_by_specimen", "Fits by specimen") }}
<p class="small">Every trial, rejected ones included: <a href="tables/fits.csv">tables/fits.csv</a>.
{% if q['fit.b_not_positive'] %}Trials used whose slope is not positive: {{ q['fit.b_not_positive'] }}.{% endif %}</p>
{{ folded("force_laws", "Other laws: power and straight line") }}
{% if 'recovery.n' in q %}
<h3>Recovery of the simulated truth</h3>
<p>Fitted slopes are {{ q['recovery.mean_b_error'] | percent(2) }} off on average, and
{{ q['recovery.coverage'] | percent(3) }} of the {{ q['recovery.confidence'] | percent(2) }} intervals hold the truth.
Fit and simulation share the law v = a + b ln F: these errors show noise and filters, not a wrong law.</p>
{{ folded("recovery", "Recovery by specimen") }}
{% elif has("recovery") %}
<p>The activity is normalised and the simulated truth is in volts, so they cannot be compared.</p>
{% endif %}
"""

FITS = Section("fits", "Fits of co-contraction against force", _TEXT, of_people, _quantities, _tables)
