"""NIST's Statistical Reference Datasets: reading the files, and counting digits.

https://www.itl.nist.gov/div898/strd/, doi 10.18434/T43G6C. Line ranges in the headers hold for these files.

What a way returns, what is known exactly of it, and how far one is from the other.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from mpmath import mpf
from numpy.typing import NDArray

from benchmarks.bench.case import NotHere

Numbers = Mapping[str, Any]
"""Arrays by name; a library leaves out what it does not give."""
Run = Callable[[], Numbers]
Exact = Mapping[str, Mapping[Any, mpf]]
"""Of some of the numbers: name, index into the array, value."""


def worst_error(exact: Callable[[], Exact]) -> Callable[[Numbers], float]:
    """Largest relative error of the numbers that a way gives, absolute where the truth is zero; NaN counts as 1."""
    known = cache(exact)

    def error(found: Numbers) -> float:
        return max(
            _error(np.asarray(found[name])[index], truth)
            for name, values in known().items()
            if name in found
            for index, truth in values.items()
        )

    return error


def exact_rows(
    exact: Callable[..., Mapping[str, mpf]], names: tuple[str, ...], *tables: np.ndarray, most: int = 20
) -> Exact:
    """Exact numbers of about ``most`` of the rows of the tables; the worst of them stands for all."""
    n = len(tables[0])
    found = {i: exact(*(table[i] for table in tables)) for i in range(0, n, max(1, n // most))}
    return {name: {i: numbers[name] for i, numbers in found.items()} for name in names}


def columns(rows: list[tuple[float, ...]], names: tuple[str, ...]) -> Numbers:
    """Numbers by name from one tuple a row."""
    return dict(zip(names, np.array(rows).T, strict=True))


def collected(rows: list[dict[str, Any]]) -> Numbers:
    """Numbers by name from one dictionary a design."""
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def looped(each: Callable[[Any], dict[str, Any]], designs: Any) -> Run:
    """A test of one design, called for every design in turn."""
    return lambda: collected([each(design) for design in designs])


def _error(value: Any, truth: mpf) -> float:
    if not np.isfinite(value):
        return 1.0
    error = abs(mpf(float(value)) - truth)
    return float(error / abs(truth) if truth else error)


NIST = Path(os.environ.get("EMG2VSA_TEST_DATA", Path(__file__).resolve().parents[2] / "shared" / "data")) / "nist"


def nist_files(folder: str) -> list[Path]:
    """The data files of one of NIST's collections, e.g. ``nist_anova``; NotHere where they are absent."""
    found = sorted((NIST / folder).glob("*.dat"))
    if not found:
        raise NotHere(f"NIST's sets {folder}: EMG2VSA_TEST_DATA names the folder that holds nist/{folder}")
    return found


def digits(value: Any, certified: str, cap: float = 15.0) -> float:
    """Log relative error against a certified number, log absolute error if that is zero; NaN and inf have none."""
    if not np.isfinite(value):
        return 0.0
    truth = Decimal(certified)
    # an extended value is split in two doubles, for Decimal takes no more
    high = float(value)
    error = abs(Decimal(high) + Decimal(float(value - type(value)(high))) - truth) / (abs(truth) or 1)
    return cap if error == 0 else max(0.0, min(cap, -float(error.log10())))


@dataclass(frozen=True)
class Regression:
    """One linear or nonlinear set: numbers as decimal text.

    y (n,), x (n, columns); estimates (p,) certified.
    """

    name: str
    y: NDArray[np.str_]
    x: NDArray[np.str_]
    estimates: tuple[str, ...]


def read_regression(path: Path) -> Regression:
    """A file of the folders nist_linear or nist_nonlinear."""
    text = path.read_text()
    first, last = map(int, re.findall(r"^ *Data +\(lines +(\d+) +to +(\d+)\)", text, re.MULTILINE)[0])
    rows = np.array([line.split() for line in text.splitlines()[first - 1 : last]])
    numbers = [line.split() for line in re.findall(r"^ *[bB]\d+ *=?( .*\d.*)$", text, re.MULTILINE)]
    numbers = [row for row in numbers if all(re.fullmatch(r"[-+.\deE]+", word) for word in row)]
    return Regression(
        name=path.stem,
        y=rows[:, 0],
        x=rows[:, 1:],
        estimates=tuple(row[-2] for row in numbers),
    )


def nonlinear_data(data: Regression) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """x and y of a set of one column."""
    return data.x[:, 0].astype(np.float64), data.y.astype(np.float64)
