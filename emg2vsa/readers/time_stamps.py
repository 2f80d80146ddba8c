"""Time stamps with a date or a time of day: ``2026-05-02T10:00:00.125``, ``2026-05-02 10:00:00Z``, ``10:00:00,125``."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from emg2vsa.errors import RecordingError

STAMP = r"(?:\d{4}[-/]\d{1,2}[-/]\d{1,2}[T ])?\d{1,2}:\d{2}:\d{2}(?:[.,]\d{1,9})?(?:\s*Z|\s*UTC|[+-]\d{2}:?\d{2})?"
"""Pattern of one."""
_STAMP = re.compile(STAMP, re.IGNORECASE)
_DATED = re.compile(r"\d{4}[-/]")
_DAY_S = 86400.0
_NAME = re.compile(r"(date|datum|date[ _/]?time|zeit(stempel)?|time([ _]?stamps?)?|timestamps?|clock|uhrzeit)", re.I)


def are_stamps(cells: Sequence[str]) -> bool:
    """Whether all cells that are filled hold a time stamp, and there are some."""
    filled = [cell for cell in cells if cell]
    return bool(filled) and all(map(_STAMP.fullmatch, filled))


def is_name_of_time(label: str) -> bool:
    """Whether a column of this name may hold them."""
    return _NAME.fullmatch(re.sub(r"\s*[\[(].*", "", label.strip())) is not None


def date_of(stamp: str) -> str:
    """The date of the midnight from which seconds count, "" where the stamp has no date or one that cannot be."""
    found = _parsed(pd.Series([stamp.strip()], dtype=object)).iloc[0]
    return "" if pd.isna(found) or not _DATED.match(stamp.strip()) else f"{found:%Y-%m-%d}"


def seconds_of(cells: Sequence[str], where: str, place: Callable[[int], str]) -> NDArray[np.float64]:
    """(n,) seconds from the midnight before the first stamp, NaN for a blank cell.

    Stamps without a date that fall by more than half a day went past midnight.

    RecordingError : a cell that is no time stamp, with its place.
    """
    texts = pd.Series(list(cells), dtype=object).fillna("").str.strip()
    bad = np.flatnonzero(((texts != "") & ~texts.str.fullmatch(STAMP, flags=re.IGNORECASE)).to_numpy())
    if bad.size:
        raise RecordingError(
            f"{where}, {place(int(bad[0]))}", wanted="a time stamp such as those above it",
            found=repr(texts.iloc[int(bad[0])]), do="Correct the cell, or remove the row.",
        )  # fmt: skip
    parsed = _parsed(texts)
    wrong = np.flatnonzero((parsed.isna() & (texts != "")).to_numpy())
    if wrong.size:
        raise RecordingError(
            f"{where}, {place(int(wrong[0]))}", wanted="a time stamp", found=repr(texts.iloc[int(wrong[0])]),
            do="Write the date as year-month-day, and all stamps alike.",
        )  # fmt: skip
    first = parsed.dropna().iloc[0] if parsed.notna().any() else pd.Timestamp(0, tz="UTC")
    seconds = np.asarray((parsed - first.normalize()).dt.total_seconds(), dtype=np.float64)
    if not texts.str.match(_DATED).any():
        seconds = seconds + _DAY_S * np.concatenate([[0], np.cumsum(np.diff(seconds) < -0.5 * _DAY_S)])
    return seconds


def _parsed(texts: pd.Series) -> pd.Series:
    """Moments in UTC, which a stamp without zone is taken to be in; without date on the first day of 1970."""
    clean = texts.str.replace(",", ".", regex=False).str.replace("/", "-", regex=False)
    clean = clean.str.replace(r"\s*(UTC|Z)$", "+00:00", regex=True, case=False)
    whole = clean.where(clean.str.match(_DATED), "1970-01-01 " + clean)
    return pd.to_datetime(whole.where(texts != "", None), format="ISO8601", errors="coerce", utc=True)
