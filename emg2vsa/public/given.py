"""What functions of the public face are given: settings, columns of a DataFrame, files, plain values; or an error."""

from __future__ import annotations

import dataclasses
import numbers
import os
from collections.abc import Mapping
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from emg2vsa.arrays import Floats
from emg2vsa.errors import DataError, SettingError, StudyError
from emg2vsa.settings import PAPER, StageSettings
from emg2vsa.study_file import contradictions
from emg2vsa.study_file.problems import Problem, checked, nearest, shown

LABELS = ("participant", "specimen", "repetition")


def of_kind(value: Any, kinds: type | tuple[type, ...], where: str, wanted: str, do: str) -> Any:
    """``value`` itself. SettingError: it is of another kind."""
    if not isinstance(value, kinds):
        raise SettingError(where, wanted=wanted, found=type(value).__name__, do=do)
    return value


def file_of(file: object, where: str, wanted: str = "the path of a file") -> Path:
    """``file`` as a path. SettingError: it is none."""
    return Path(of_kind(file, (str, os.PathLike), where, wanted, "Give the path as text or pathlib.Path."))


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
    """A column as a new array of floats (n,), NaN where a value is missing. DataError: it holds anything else.

    True and False are no numbers here: they are the marks of a trigger, and no signal.
    """
    cells = column(table, name, where)
    is_other = pd.api.types.is_complex_dtype(cells) or pd.api.types.is_bool_dtype(cells)
    whole = pd.api.types.is_numeric_dtype(cells) and not is_other
    if not whole and cells.dtype != object:
        raise _no_numbers(where, name, wanted, f"{cells.dtype} values")
    if not whole:
        for value in cells:
            is_number = isinstance(value, (numbers.Real, Decimal)) and not isinstance(value, bool)
            if not is_number and not is_missing(value):
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


_KINDS = {field.name: field for field in dataclasses.fields(StageSettings)}


class Settings(StageSettings):
    """Settings of reading, filters, fits, tests, profiles and schedules; each has its default.

    Parameters
    ----------
    paper : take the paper's values where nothing else is said, as ``mode = "paper"`` does in a study file.
    tables : the tables of a study file, each a mapping of keys to values, such as ``window={"force_n": (1.0, 6.0)}``.
        docs/reference/study-file.md explains every key.

    Raises
    ------
    SettingError : a table that is none. StudyError : every key or value that cannot be, alone or with others, each in
    a line.
    """

    def __init__(self, *, paper: bool = False, **tables: Mapping[str, Any]) -> None:
        if not isinstance(paper, bool):
            do = "Write paper=True, or leave it out."
            raise SettingError("Settings, paper", wanted="True or False", found=shown(paper), do=do)
        for name in tables:
            if name not in _KINDS:
                do = nearest(name, _KINDS, "Choose one of them.")
                raise SettingError("Settings", wanted=f"tables {', '.join(_KINDS)}", found=repr(name), do=do)
        made: dict[str, Any] = {}
        problems: list[Problem] = []
        for name in _KINDS:
            kind = type(getattr(_DEFAULTS, name))
            values = {**(PAPER.get(name, {}) if paper else {}), **_table(name, tables.get(name, {}))}
            if kind is type(None):
                continue
            made[name], found = checked(kind, values, (name,))
            problems += found
        faulty = {problem.path[0] for problem in problems}
        problems += contradictions({name: table for name, table in made.items() if name not in faulty})
        if problems:
            raise StudyError(tuple(f"Settings: {problem}" for problem in dict.fromkeys(problems)))
        super().__init__(**made)

    def __repr__(self) -> str:
        """Only what differs from the defaults."""
        said = []
        for name in _KINDS:
            mine, usual = getattr(self, name), getattr(_DEFAULTS, name)
            if mine != usual:
                fields = (field.name for field in dataclasses.fields(mine))
                changed = {key: getattr(mine, key) for key in fields if getattr(mine, key) != getattr(usual, key)}
                said.append(f"{name}={changed}")
        return f"Settings({', '.join(said)})"


_DEFAULTS = StageSettings()


def _table(name: str, values: object) -> dict[str, Any]:
    if not isinstance(values, Mapping):
        do = f"Write Settings({name}={{...}})."
        raise SettingError(f"Settings, {name}", wanted="a mapping of keys to values", found=repr(values), do=do)
    for key in values:
        if not isinstance(key, str):
            do = "Name a key of the study file."
            raise SettingError(f"Settings, {name}", wanted="keys as text", found=repr(key), do=do)
    return dict(plain(values))


def settings_or_default(settings: StageSettings | None) -> StageSettings:
    """``settings``, or every default where they are None. SettingError: they are anything else."""
    do = "Make them so: emg2vsa.Settings(window={...}); a study that load gave, as load(file).study, will do too."
    usable: StageSettings = of_kind(
        _DEFAULTS if settings is None else settings, StageSettings, "settings", "emg2vsa.Settings", do
    )
    return usable
