"""Condition, angle and specimen in one model of the rig's scores."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, fields_of, with_interval
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Column, Columns, Table, columns, table_of
from emg2vsa.statistics.factorial import Factorial

_SCORES = {"start_area": "area", "casr": "CASR"}


def _factors(results: StudyResults) -> dict[str, Factorial]:
    found = results.runs.discrimination if results.runs else None
    models = {"start_area": found.factors.area, "casr": found.factors.casr} if found else {}
    return {name: model for name, model in models.items() if model is not None}


def _applies(results: StudyResults) -> bool:
    return bool(_factors(results))


def _quantities(results: StudyResults) -> Items:
    for score, model in _factors(results).items():
        for i, effect in enumerate(model.effects):
            key = f"runs.factors.{score}.{effect.replace(' × ', '-')}"
            yield from fields_of(key, model, "f", "df", "p", "eta2", at=i)
            yield from with_interval(f"{key}.omega2", model.omega2[i], model.low[i], model.high[i])


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
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
        for score, model in _factors(results).items()
    ]
    caption = "Condition, angle and specimen in one model of ln(score), type II (means of mountings on the rig)"
    joined = {column: np.concatenate([each[column] for each in every]) for column in every[0]}
    yield table_of("factors", caption, joined)


_TEXT = """
<p>One model of the logarithm of each score tests condition, angle and specimen together, because they multiply it.</p>
{{ folded("factors", "Effects of condition, angle and specimen") }}
"""

FACTORS = Section("factors", "Condition, angle and specimen", _TEXT, _applies, _quantities, _tables)
