"""Products as DataFrames: fields of one value a row become columns."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import Any

import numpy as np
import pandas as pd

from emg2vsa.statistics.outcome import Outcome


def frame_of(product: Any, rows: int) -> pd.DataFrame:
    """The fields of a dataclass that hold ``rows`` values each, (rows,), as columns of their names."""
    columns = {}
    for field in dataclasses.fields(product):
        value = getattr(product, field.name)
        if isinstance(value, np.ndarray) and value.shape == (rows,):
            columns[field.name] = value
        elif isinstance(value, tuple) and len(value) == rows and all(isinstance(one, str) for one in value):
            columns[field.name] = np.array(value, dtype=object)
    return pd.DataFrame(columns)


OUTCOME_COLUMNS = (
    "of", "method", "n", "statistic_name", "statistic", "df", "p", "estimate_name", "estimate", "estimate_lo",
    "estimate_hi", "confidence", "effect_name", "effect_size", "notes",
)  # fmt: skip


def outcomes_frame(found: Iterable[tuple[str, Outcome]]) -> pd.DataFrame:
    """Outcomes of tests, each with what was tested, one row each."""
    rows = []
    for of, outcome in found:
        row = {"of": of, **dataclasses.asdict(outcome)}
        row["estimate_lo"], row["estimate_hi"] = row.pop("interval") or (None, None)
        row["notes"] = "; ".join(outcome.notes)
        rows.append(row)
    frame = pd.DataFrame(rows, columns=list(OUTCOME_COLUMNS))
    numbers = ("statistic", "p", "estimate", "estimate_lo", "estimate_hi", "confidence", "effect_size")
    return frame.astype(dict.fromkeys(numbers, np.float64))
