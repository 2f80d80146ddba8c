"""Columns of a DataFrame by the headers that files have: ``EDC (mV)``, ``Fz [N]``, ``time [s]``."""

from __future__ import annotations

from typing import Any

import pandas as pd

from emg2vsa.errors import SettingError
from emg2vsa.readers.plain_csv import time_unit_s
from emg2vsa.readers.units import si_factor, split_unit


def headed(table: pd.DataFrame, name: Any) -> tuple[Any, str | None]:
    """The column that is called so, with or without the unit in its header, and that unit.

    The name itself, without a unit, where no column or several are called so.
    """
    known = [label for label in table.columns if isinstance(label, str)]
    labels = [name] if name in known else [label for label in known if split_unit(label, glued=True)[0] == name]
    return (labels[0], split_unit(labels[0], glued=True)[1]) if len(labels) == 1 else (name, None)


def unit_of(table: pd.DataFrame, name: Any, told: str | None, usual: str | None, option: str) -> str | None:
    """The unit that is ``told``; without it ``usual`` where the header of the column states none, else None.

    SettingError : header and ``told``, as ``option`` gave it, are two units.
    """
    label, stated = headed(table, name)
    if told is None:
        return usual if stated is None else None
    if stated is not None and told != stated and (si_factor(told) is None or si_factor(told) != si_factor(stated)):
        do = f"Leave {option} out, or rename the column."
        raise SettingError(f"read, {option}", wanted=f"{stated}, as {label} says", found=repr(told), do=do)
    return told


def clock(table: pd.DataFrame, *, has_rate: bool) -> tuple[str, float] | None:
    """The column of times and the seconds in its unit, if there is one.

    ``time_s`` goes before others. A time that states no unit is in seconds, and not looked at where a rate is given.
    """
    if "time_s" in table.columns:
        return "time_s", 1.0
    told = [(label, time_unit_s(label)) for label in table.columns if isinstance(label, str)]
    times = [(label, unit_s or 1.0) for label, (is_time, unit_s) in told if is_time and (unit_s or not has_rate)]
    return times[0] if len(times) == 1 else None
