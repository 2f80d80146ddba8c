"""NIST's Statistical Reference Datasets: reading the files, the models of the nonlinear ones, and counting digits.

https://www.itl.nist.gov/div898/strd/, doi 10.18434/T43G6C. Line ranges in the headers hold for these files.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.bench.case import NotHere
from emg2vsa.curves.nonlinear import Model

NIST = Path(os.environ.get("EMG2VSA_TEST_DATA", Path(__file__).resolve().parents[2] / "shared" / "data")) / "nist"

LINEAR_DEGREE = {
    "Norris": 1, "Pontius": 2, "NoInt1": 1, "NoInt2": 1, "Filip": 10, "Longley": None,
    "Wampler1": 5, "Wampler2": 5, "Wampler3": 5, "Wampler4": 5, "Wampler5": 5,
}  # fmt: skip
"""Degree of the polynomial; None: the columns as they are."""


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

    y (n,), x (n, columns); estimates, errors (p,) certified; starts (2, p) or empty; residual_sd certified.
    """

    name: str
    y: NDArray[np.str_]
    x: NDArray[np.str_]
    estimates: tuple[str, ...]
    errors: tuple[str, ...]
    starts: NDArray[np.float64]
    residual_sd: str
    r2: str | None


def read_regression(path: Path) -> Regression:
    """A file of the folders nist_linear or nist_nonlinear."""
    text = path.read_text()
    first, last = map(int, re.findall(r"^ *Data +\(lines +(\d+) +to +(\d+)\)", text, re.MULTILINE)[0])
    rows = np.array([line.split() for line in text.splitlines()[first - 1 : last]])
    numbers = [line.split() for line in re.findall(r"^ *[bB]\d+ *=?( .*\d.*)$", text, re.MULTILINE)]
    numbers = [row for row in numbers if all(re.fullmatch(r"[-+.\deE]+", word) for word in row)]
    found = re.search(r"R-Squared +(\S+)", text)
    return Regression(
        name=path.stem,
        y=rows[:, 0],
        x=rows[:, 1:],
        estimates=tuple(row[-2] for row in numbers),
        errors=tuple(row[-1] for row in numbers),
        starts=np.array([row[:-2] for row in numbers], dtype=np.float64).T,
        residual_sd=re.findall(r"Standard Deviation:? +(\S+)", text)[0 if "Start" not in text else -1],
        r2=found and found.group(1),
    )


def _enso(x: Any, b: Any) -> Any:
    def wave(period: Any, cosine: Any, sine: Any) -> Any:
        return cosine * np.cos(2 * np.pi * x / period) + sine * np.sin(2 * np.pi * x / period)

    return b[0] + wave(12, b[1], b[2]) + wave(b[3], b[4], b[5]) + wave(b[6], b[7], b[8])


def _gauss(x: Any, b: Any) -> Any:
    peaks = b[2] * np.exp(-(((x - b[3]) / b[4]) ** 2)) + b[5] * np.exp(-(((x - b[6]) / b[7]) ** 2))
    return b[0] * np.exp(-b[1] * x) + peaks


def _lanczos(x: Any, b: Any) -> Any:
    return b[0] * np.exp(-b[1] * x) + b[2] * np.exp(-b[3] * x) + b[4] * np.exp(-b[5] * x)


def _chwirut(x: Any, b: Any) -> Any:
    return np.exp(-b[0] * x) / (b[1] + b[2] * x)


def _cubic_over_cubic(x: Any, b: Any) -> Any:
    return (b[0] + x * (b[1] + x * (b[2] + x * b[3]))) / (1 + x * (b[4] + x * (b[5] + x * b[6])))


def _saturation(x: Any, b: Any) -> Any:
    return -b[0] * np.expm1(-b[1] * x)


MODELS: dict[str, Model] = {
    "Misra1a": _saturation,
    "Chwirut2": _chwirut,
    "Chwirut1": _chwirut,
    "Lanczos3": _lanczos,
    "Gauss1": _gauss,
    "Gauss2": _gauss,
    "DanWood": lambda x, b: b[0] * x ** b[1],
    "Misra1b": lambda x, b: b[0] * (1 - (1 + b[1] * x / 2) ** -2),
    "Kirby2": lambda x, b: (b[0] + x * (b[1] + x * b[2])) / (1 + x * (b[3] + x * b[4])),
    "Hahn1": _cubic_over_cubic,
    "Nelson": lambda x, b: b[0] - b[1] * x[:, 0] * np.exp(-b[2] * x[:, 1]),
    "MGH17": lambda x, b: b[0] + b[1] * np.exp(-x * b[3]) + b[2] * np.exp(-x * b[4]),
    "Lanczos1": _lanczos,
    "Lanczos2": _lanczos,
    "Gauss3": _gauss,
    "Misra1c": lambda x, b: b[0] * (1 - (1 + 2 * b[1] * x) ** -0.5),
    "Misra1d": lambda x, b: b[0] * b[1] * x / (1 + b[1] * x),
    "Roszman1": lambda x, b: b[0] - b[1] * x - np.arctan(b[2] / (x - b[3])) / np.pi,
    "ENSO": _enso,
    "MGH09": lambda x, b: b[0] * (x * x + x * b[1]) / (x * x + x * b[2] + b[3]),
    "Thurber": _cubic_over_cubic,
    "BoxBOD": _saturation,
    "Rat42": lambda x, b: b[0] / (1 + np.exp(b[1] - b[2] * x)),
    "MGH10": lambda x, b: b[0] * np.exp(b[1] / (x + b[2])),
    "Eckerle4": lambda x, b: b[0] / b[1] * np.exp(-0.5 * ((x - b[2]) / b[1]) ** 2),
    "Rat43": lambda x, b: b[0] / (1 + np.exp(b[1] - b[2] * x)) ** (1 / b[3]),
    "Bennett5": lambda x, b: b[0] * (b[1] + x) ** (-1 / b[2]),
}
"""The 27 nonlinear sets, easy ones first; complex parameters are welcome."""


def nonlinear_data(data: Regression) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """x and y of a nonlinear set as its model takes them (Nelson: two columns, and ln y)."""
    x, y = data.x.astype(np.float64), data.y.astype(np.float64)
    return (x, np.log(y)) if data.name == "Nelson" else (x[:, 0], y)
