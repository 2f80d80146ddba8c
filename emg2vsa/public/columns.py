"""What functions of the public face are given: columns of a DataFrame, files and plain values, or one clear error."""

from __future__ import annotations

import numbers
import os
from collections.abc import Mapping
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from emg2vsa.arrays import Floats
from emg2vsa.errors import DataError, SettingError
from emg2vsa.study_file.problems import nearest, shown

LABELS = ("participant", "specimen", "repetition")


def table_of(table: object, where: str) -> pd.DataFrame:
    """``table`` itself. SettingError: it is no DataFrame."""
    if not isinstance(table, pd.DataFrame):
        do = "Make a DataFrame of it: pandas.DataFrame(...)."
        raise SettingError(where, wanted="a DataFrame", found=type(table).__name__, do=do)
    return table


def file_of(file: object, where: str, wanted: str = "the path of a file") -> Path:
    """``file`` as a path. SettingError: it is none."""
    if not isinstance(file, (str, os.PathLike)):
        do = "Give the path as text or pathlib.Path."
        raise SettingError(where, wanted=wanted, found=type(file).__name__, do=do)
    return Path(file)


def column(table: pd.DataFrame, name: object, where: str = "DataFrame") -> pd.Series:
    """The one column of that name. DataError: there is none, or there are several."""
    if not isinstance(name, (str, int)) or isinstance(name, bool):
        do = "Give the name of a column."
        raise DataError(where, wanted="a column's name", found=shown(plain(name)), do=do)
    count = sum(type(one) is type(name) and one == name for one in map(plain, table.columns))
    if count == 0:
        known = [str(one) for one in table.columns]
        do = nearest(str(name), known, "Choose one of them, or rename the column.")
        raise DataError(where, wanted=f"a column {name!r}", found=f"columns {', '.join(known) or 'none'}", do=do)
    if count > 1:
        do = "Rename or drop the others."
        raise DataError(where, wanted=f"one column {name!r}", found=f"{count} of that name", do=do)
    found: pd.Series = table[name]
    return found


def numbers_of(table: pd.DataFrame, name: object, where: str = "DataFrame", wanted: str = "numbers") -> Floats:
    """A column as a new array of floats (n,), NaN where a value is missing. DataError: it holds anything else."""
    cells = column(table, name, where)
    whole = pd.api.types.is_numeric_dtype(cells) and not pd.api.types.is_complex_dtype(cells)
    if not whole and cells.dtype != object:
        raise _no_numbers(where, name, wanted, f"{cells.dtype} values")
    if not whole:
        for value in cells:
            if not isinstance(value, (numbers.Real, Decimal)) and not is_missing(value):
                raise _no_numbers(where, name, wanted, repr(value))
    return np.array(pd.to_numeric(cells).to_numpy(np.float64, na_value=np.nan))


def _no_numbers(where: str, name: object, wanted: str, found: str) -> DataError:
    do = "Convert the column to plain numbers first."
    return DataError(f"{where}, column {name!r}", wanted=wanted, found=found, do=do)


def refuse_missing_labels(table: pd.DataFrame, where: str) -> None:
    """DataError: a column that tells people, specimens or repetitions is blank in a row."""
    for name in LABELS:
        if name in table.columns and (blank := np.flatnonzero(column(table, name, where).isna())).size:
            raise DataError(
                f"{where}, column {name!r}", wanted="a name in every row",
                found=f"none in {blank.size} rows, the first at position {blank[0]}",
                do="Fill the cells in, or leave these rows out.",
            )  # fmt: skip


def is_missing(value: Any) -> bool:
    """Whether a cell is blank: None, NaN, NaT or pandas.NA."""
    return value is None or bool(pd.api.types.is_scalar(value) and pd.isna(value))


def number_of(value: object) -> float | None:
    """A plain number that is finite, as a float; None for anything else."""
    value = plain(value)
    if isinstance(value, bool) or not isinstance(value, (numbers.Real, Decimal)):
        return None
    try:
        number = float(value)
    except (OverflowError, ValueError):
        return None
    return number if np.isfinite(number) else None


def plain(value: Any) -> Any:
    """NumPy's numbers and arrays, and any mapping, as Python's own, however deep."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, Mapping):
        return {key: plain(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return type(value)(map(plain, value)) if type(value) in (list, tuple) else [plain(one) for one in value]
    return value
