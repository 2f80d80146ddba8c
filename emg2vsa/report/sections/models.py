"""Models of all data at once: scatter between people, trend, and factors of the rig's scores."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from emg2vsa.figures.cocontraction import draw_mixed_residuals
from emg2vsa.hypotheses import Hypotheses
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, fields_of, plain, with_interval
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import FEW_ON_PAGE, Column, Columns, Table, activity_column, columns, table_of
from emg2vsa.report.wording import listed, number
from emg2vsa.statistics.factorial import Factorial
from emg2vsa.statistics.mixed_variances import SOURCES, MixedResiduals, MixedVariances


def _hypotheses(results: StudyResults) -> Hypotheses | None:
    return results.people.hypotheses if results.people else None


def _applies(results: StudyResults) -> bool:
    return _hypotheses(results) is not None or bool(results.runs and results.runs.discrimination)


def _variances(results: StudyResults) -> tuple[MixedVariances | None, MixedResiduals | None]:
    found = _hypotheses(results)
    blocks = found.tests.blocks if found else None
    return (blocks.variances, blocks.residuals) if blocks else (None, None)


def _factors(results: StudyResults) -> dict[str, Factorial]:
    found = results.runs.discrimination if results.runs else None
    models = {"start_area": found.factors.area, "casr": found.factors.casr} if found else {}
    return {name: model for name, model in models.items() if model is not None}


def _quantities(results: StudyResults) -> Items:
    variances, residuals = _variances(results)
    name, unit = "hypotheses.over_people.mixed", results.activity_suffix if results.people else ""
    for i, source in enumerate(SOURCES if variances else ()):
        assert variances is not None
        ends = (variances.sd[i], variances.low[i], variances.high[i])
        yield from with_interval(f"{name}.sd_{source.replace(' ', '_')}{unit}", *ends)
    if residuals is not None:
        normal, level = residuals.outcomes()
        yield f"{name}.residuals.shapiro_p", plain(normal.p)
        yield f"{name}.residuals.level_rho", plain(level.effect_size)
        yield f"{name}.residuals.level_p", plain(level.p)
    if (found := _hypotheses(results)) is not None:
        trend = found.trend
        yield from with_interval(f"hypotheses.trend.b{unit}_per_repetition", trend.mean, trend.low, trend.high)
        yield "hypotheses.trend.relative_per_repetition", trend.per_mean
        yield "hypotheses.trend.p", trend.p
    for score, model in _factors(results).items():
        for i, effect in enumerate(model.effects):
            key = f"runs.factors.{score}.{effect.replace(' × ', '-')}"
            yield from fields_of(key, model, "f", "df", "p", "eta2", at=i)
            yield from with_interval(f"{key}.omega2", model.omega2[i], model.low[i], model.high[i])


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    variances, residuals = _variances(results)
    if variances is not None:
        yield _sd_table(results, variances)
    if residuals is not None:
        left: Columns = {
            activity_column("fitted_v", "Fitted b", results.scale): residuals.fitted,
            **columns(residuals, "residual", "quantile"),
        }
        caption = "Residuals of the mixed model, for a QQ plot and for residuals against fitted values"
        yield table_of("mixed_residuals", caption, left)
    if (found := _hypotheses(results)) is not None:
        slopes: Columns = {
            Column("participant", "Participant"): found.trend.blocks,
            activity_column("slope_v", "Change of b per repetition", results.scale): found.trend.slope,
        }
        yield table_of("trend", "Trend of b over the repetitions of each participant", slopes, FEW_ON_PAGE)
    if models := _factors(results):
        yield _factor_table(models)


def _sd_table(results: StudyResults, variances: MixedVariances) -> Table:
    shown: Columns = {
        Column("source", "Source"): SOURCES,
        activity_column("sd_v", "SD of b", results.scale): variances.sd,
        activity_column("low_v", "Low", results.scale): variances.low,
        activity_column("high_v", "High", results.scale): variances.high,
        Column("ratio", "SD / SD of repetitions"): [*variances.ratio[:2].tolist(), 1.0],
        Column("ratio_low", "Low"): [*variances.ratio_low[:2].tolist(), None],
        Column("ratio_high", "High"): [*variances.ratio_high[:2].tolist(), None],
    }
    caption = "Scatter of b by the mixed model: standard deviations (REML) and their profile-likelihood intervals"
    if zero := [source for source, sd in zip(SOURCES, variances.sd, strict=True) if sd == 0]:
        caption += f". The likelihood is largest where {listed(zero)} do not scatter: only the upper limit informs"
    return table_of("mixed_sd", caption, shown)


_FAR = 3
"""Of 370 normal residuals, one lies farther from zero than so many SDs."""
_SCORES = {"start_area": "area", "casr": "CASR"}


def _factor_table(models: dict[str, Factorial]) -> Table:
    every: list[Columns] = [
        {
            Column("score", "Score"): [_SCORES[score]] * len(model.effects),
            Column("effect", "Effect"): model.effects,
            **columns(model, "f", "df"),
            Column("error_df", "Error df"): [model.error_df] * len(model.effects),
            **columns(model, "p", "eta2", "omega2"),
            Column("omega2_low", "ω² low"): model.low,
            Column("omega2_high", "ω² high"): model.high,
        }
        for score, model in models.items()
    ]
    caption = "Condition, angle and specimen in one model of ln(score), type II (means of mountings on the rig)"
    joined = {column: np.concatenate([each[column] for each in every]) for column in every[0]}
    return table_of("factors", caption, joined)


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    _, found = _variances(results)
    if found is None:
        return
    least, most = (number(float(end)) for end in (found.residual.min(), found.residual.max()))
    yield Drawing(
        "mixed_residuals",
        "Residuals of the mixed model",
        "Residuals of the mixed model, in SDs of repetitions: (a) against normal quantiles, where normal residuals lie "
        "near the dashed line; (b) against fitted b, where an equal scatter fills a band of one width.",
        f"{found.residual.size} residuals from {least} to {most} SDs of repetitions; "
        f"{np.count_nonzero(np.abs(found.residual) > _FAR)} lie farther than {_FAR} SDs from zero.",
        draw_mixed_residuals(found.fitted, found.residual, found.quantile, results.scale),
        None,
    )


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    found = _hypotheses(results)
    return {"trend": found.trend if found else None}


_TEXT = """
{% if has("mixed_residuals") %}
<p>The mixed model of b assumes normal residuals with one scatter at every level: the tests of both assumptions give
{{ q["hypotheses.over_people.mixed.residuals.shapiro_p"] | p }} and
{{ q["hypotheses.over_people.mixed.residuals.level_p"] | p }}.</p>
{% endif %}
{{ folded("mixed_sd", "Scatter of b between people and between repetitions") }}
{{ folded("mixed_residuals", "Residuals of the mixed model") }}
{% if trend is not none and trend.p == trend.p %}
<p>From one repetition to the next, b changes by {{ trend.per_mean | percent(2) }} of its mean ({{ trend.p | p }};
{{ "t test over participants" if trend.over_blocks else "regression within one participant" }}).</p>
{{ folded("trend", "Trend of every participant") }}
{% endif %}
{{ folded("factors", "Condition, angle and specimen in one model of the rig's scores") }}
"""

MODELS = Section("models", "All data together", _TEXT, _applies, _quantities, _tables, _drawings, words=_words)
