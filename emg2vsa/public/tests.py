"""Every usual test on a tidy table, with its companions."""

from __future__ import annotations

from decimal import Decimal
from os import PathLike
from pathlib import Path

import numpy as np
import pandas as pd

from emg2vsa import __version__
from emg2vsa.companions.tidy import tidy_tests
from emg2vsa.errors import DataError, SettingError
from emg2vsa.public.frames import outcomes_frame
from emg2vsa.readers.tidy_table import read_tidy_table
from emg2vsa.report.tidy_text import outcomes, text
from emg2vsa.study_file.problems import nearest


def stats(
    table: str | PathLike[str] | pd.DataFrame,
    *,
    value: str,
    group: str,
    block: str | None = None,
    alpha: float = 0.05,
    margin: float | None = None,
    protected: bool = False,
) -> pd.DataFrame:
    """Compare groups of a tidy table (one row an observation): one row a test, companions beside each usual one.

    Parameters
    ----------
    table : a DataFrame, or a CSV or TSV file. value : column of numbers. group : column that tells the groups.
    block : column of people or objects that gave several rows; tests then run within and over blocks too.
    alpha : level of the tests. margin : of tests of equality, in the unit of the values. protected : Fisher's LSD only
    after a significant F.

    Columns: of, method, n, statistic_name, statistic, df, p, estimate_name, estimate, estimate_lo, estimate_hi,
    confidence, effect_name, effect_size, notes. ``attrs["text"]`` is what ``emg2vsa stats`` prints.
    DataError : a column is missing or holds no numbers, or there are too few groups or rows.
    """
    if not 0 < alpha < 0.5:
        raise SettingError("alpha", wanted="a level between 0 and 0.5", found=repr(alpha), do="Choose one, as 0.05.")
    if margin is not None and not 0 < margin < np.inf:
        raise SettingError("margin", wanted="a number above 0", found=repr(margin), do="Choose such a margin.")
    if isinstance(table, pd.DataFrame):
        columns = {name: _column(table, name) for name in (value, group, *([block] if block else []))}
        numbers = [_number(one, value) for one in columns[value]]
        groups, blocks = _names(columns[group]), _names(columns[block]) if block else None
    else:
        read = read_tidy_table(Path(table))
        numbers, groups, blocks = read.numbers(value), read.texts(group), read.texts(block) if block else None
    found = tidy_tests(numbers, groups, blocks, alpha, margin, protected=protected)
    frame = outcomes_frame(outcomes(found))
    frame.attrs = {
        "value": value, "group": group, "block": block, "alpha": alpha, "n": found.n,
        "left_out": found.without_number + found.without_name, "text": text(found, "plain", details=False),
        "emg2vsa": __version__,
    }  # fmt: skip
    return frame


def _column(table: pd.DataFrame, name: str) -> pd.Series:
    if name not in table.columns:
        known = [str(one) for one in table.columns]
        do = nearest(name, known, "Choose one of them.")
        raise DataError("DataFrame", wanted=f"a column {name!r}", found=f"columns {', '.join(known)}", do=do)
    return table[name]


def _number(value: object, column: str) -> Decimal | None:
    """The exact value of a float; None for a missing one."""
    if value is None or value is pd.NA or value != value:  # NaN differs from itself
        return None
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        number = float("inf")
    if not np.isfinite(number):
        do = "Correct the cell, or make it NaN."
        raise DataError(f"DataFrame, column {column!r}", wanted="finite numbers or NaN", found=repr(value), do=do)
    return Decimal(repr(number))


def _names(column: pd.Series) -> list[str]:
    return ["" if pd.isna(one) else str(one) for one in column]
