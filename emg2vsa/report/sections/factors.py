"""Condition, angle and specimen in one model of the rig's scores."""

from __future__ import annotations

from collections.abc import Iterator

from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, fields_of, with_interval
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Column, Columns, Table, from_quantities, table_of
from emg2vsa.shown import words_of
from emg2vsa.statistics.factorial import Factorial

_SCORES = {"start_area": "area", "casr": "CASR"}


def _factors(results: StudyResults) -> dict[str, Factorial]:
    found = results.runs.discrimination if results.runs else None
    models = {score: getattr(found.factors, name.lower()) for score, name in _SCORES.items()} if found else {}
    return {score: model for score, model in models.items() if model is not None}


def _quantities(results: StudyResults) -> Items:
    for score, model in _factors(results).items():
        for i, effect in enumerate(model.effects):
            key = f"runs.factors.{score}.{effect.replace(' × ', '-')}"
            yield from fields_of(key, model, "f", "df", "p", "eta2", at=i)
            yield from with_interval(f"{key}.omega2", model.omega2[i], model.low[i], model.high[i])


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    every = [(score, model, effect) for score, model in _factors(results).items() for effect in model.effects]
    names = [f"runs.factors.{score}.{effect.replace(' × ', '-')}" for score, _, effect in every]
    head = words_of(Factorial)
    rows: Columns = {
        Column("score", "Score"): [_SCORES[score] for score, *_ in every],
        Column("effect", "Effect"): [effect for *_, effect in every],
        **from_quantities(q, names, {Column(key, *head[key]): key for key in ("f", "df")}),
        Column("error_df", "Error df"): [model.error_df for _, model, _ in every],
        **from_quantities(q, names, {Column(key, *head[key]): key for key in ("p", "eta2", "omega2")}),
        Column("omega2_low", "ω² low"): [q[f"{name}.omega2.low"] for name in names],
        Column("omega2_high", "ω² high"): [q[f"{name}.omega2.high"] for name in names],
    }
    caption = "Condition, angle and specimen in one model of ln(score), type II (means of mountings on the rig)"
    yield table_of("factors", caption, rows)


_TEXT = """
<p>One model of the logarithm of each score tests condition, angle and specimen together, because they multiply it.</p>
{{ folded("factors", "Effects of condition, angle and specimen") }}
"""

FACTORS = Section(
    "factors", "Condition, angle and specimen", _TEXT, lambda results: bool(_factors(results)), _quantities, _tables
)
