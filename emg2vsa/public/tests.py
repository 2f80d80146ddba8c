"""Every usual test on a tidy table, with its companions."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from contextlib import suppress
from decimal import Decimal
from os import PathLike
from pathlib import Path

import numpy as np
import pandas as pd

from emg2vsa import __version__
from emg2vsa.companions.tidy import tidy_tests
from emg2vsa.errors import DataError, RecordingError, SettingError
from emg2vsa.public.given import column, file_of, is_missing, number_of, plain
from emg2vsa.readers.tidy_table import TidyTable, read_tidy_table
from emg2vsa.report.tidy_text import outcomes, text
from emg2vsa.statistics.outcome import Outcome
from emg2vsa.study_file.problems import shown

_COLUMNS = (
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
    frame = pd.DataFrame(rows, columns=list(_COLUMNS))
    numbers = ("statistic", "p", "estimate", "estimate_lo", "estimate_hi", "confidence", "effect_size")
    return frame.astype(dict.fromkeys(numbers, np.float64))


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
    level = number_of(alpha)
    if level is None or not 0 < level < 0.5:
        raise SettingError("alpha", wanted="a level between 0 and 0.5", found=shown(alpha), do="Choose one, as 0.05.")
    margin_of_equality = None if margin is None else number_of(margin)
    if margin is not None and not (margin_of_equality and margin_of_equality > 0):
        raise SettingError("margin", wanted="a number above 0", found=shown(margin), do="Choose such a margin.")
    for role, name in {"value": value, "group": group, "block": block}.items():
        if not isinstance(name, (str, int)) and not (role == "block" and name is None):
            do = f"Give the column: {role}='NAME'."
            raise SettingError(f"stats, {role}", wanted="a column's name", found=shown(plain(name)), do=do)
    if isinstance(table, pd.DataFrame):
        columns = {name: column(table, name) for name in (value, group, *([] if block is None else [block]))}
        numbers = [_number(one, value) for one in columns[value]]
        groups, blocks = _names(columns[group]), _names(columns[block]) if block is not None else None
    else:
        read = _read(file_of(table, "stats", "a DataFrame or the path of a file"))
        numbers, groups = read.numbers(value), read.texts(group)
        blocks = read.texts(block) if block is not None else None
    found = tidy_tests(numbers, groups, blocks, level, margin_of_equality, protected=protected)
    frame = outcomes_frame(outcomes(found))
    frame.attrs = {
        "value": value, "group": group, "block": block, "alpha": level, "n": found.n,
        "left_out": found.without_number + found.without_name, "text": text(found, "plain", details=False),
        "emg2vsa": __version__,
    }  # fmt: skip
    return frame


def _read(file: Path) -> TidyTable:
    try:
        return read_tidy_table(file)
    except OSError as error:
        found = error.strerror or "an error"
        raise RecordingError(file, wanted="a readable file", found=found, do="Check the path.") from error


def _number(value: object, column: str) -> Decimal | None:
    """The exact value of a number, whatever its type; None for a missing one."""
    value = plain(value)
    with suppress(ValueError, ArithmeticError):
        if is_missing(value):
            return None
        if isinstance(value, (int, float, str, Decimal)):
            exact = Decimal(repr(value)) if isinstance(value, float) else Decimal(value)
            # beyond the reach of float64 no test can say anything, and exact arithmetic would not end
            if exact == 0 or (exact.is_finite() and 0 < abs(float(exact)) < float("inf")):
                return exact
    do, found = "Correct the cell, or make it NaN.", repr(value) if isinstance(value, str) else shown(value)
    raise DataError(f"DataFrame, column {column!r}", wanted="finite numbers or NaN", found=found, do=do)


def _names(column: pd.Series) -> list[str]:
    return ["" if pd.isna(one) else str(one) for one in column]
