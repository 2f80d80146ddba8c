"""NIST's linear and nonlinear regressions: digits beside other libraries."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from scipy import optimize

from benchmarks.nist import LINEAR_DEGREE, MODELS, Regression, digits, nonlinear_data, read_regression
from benchmarks.statistics.digit_table import DigitTable, files
from benchmarks.statistics.linear import fit_linear, powers
from benchmarks.statistics.peers import statsmodels_api
from emg2vsa.curves.exponential import fit_exponential
from emg2vsa.curves.nonlinear import fit_nonlinear

CERTIFIED = 11.0
"""Digits of NIST's nonlinear values."""


def worst(found: Iterable[float], certified: tuple[str, ...], cap: float = 15.0) -> float:
    return min(digits(value, truth, cap) for value, truth in zip(found, certified, strict=True))


def linear_table() -> DigitTable | None:
    """Digits of the worst coefficient and of the worst standard error."""
    rows = {path.stem: _linear_row(read_regression(path)) for path in files("nist_linear")}
    title = (
        "NIST linear regressions: digits of the worst coefficient, and of the worst standard error (SE)\n"
        "text: emg2vsa in extended precision from decimal text; pinv, qr: statsmodels OLS"
    )
    return DigitTable(title, {name: rows[name] for name in LINEAR_DEGREE}) if rows else None


def _linear_row(data: Regression) -> dict[str, float]:
    degree = LINEAR_DEGREE[data.name]
    intercept = not data.name.startswith("NoInt")
    text_x = data.x.astype(np.longdouble) if degree is None else powers(data.x[:, 0], degree)
    x, y = text_x.astype(np.float64), data.y.astype(np.float64)
    from_text = fit_linear(text_x, data.y.astype(np.longdouble), intercept=intercept)
    ours = fit_linear(x, y, intercept=intercept)
    design = np.column_stack([np.ones(y.size), x]) if intercept else x
    found = {
        "emg2vsa": (ours.coefficients[0], data.estimates),
        "emg2vsa SE": (ours.se[0], data.errors),
        "text": (from_text.coefficients[0], data.estimates),
        "text SE": (from_text.se[0], data.errors),
        "lstsq": (np.linalg.lstsq(design, y, rcond=None)[0], data.estimates),
    }
    if statsmodels_api is not None:
        for method in ("pinv", "qr"):
            fit = statsmodels_api.OLS(y, design).fit(method=method)
            found |= {method: (fit.params, data.estimates), f"{method} SE": (fit.bse, data.errors)}
    return {name: worst(*pair) for name, pair in found.items()}


def nonlinear_table() -> DigitTable | None:
    """Digits of the worst parameter from both starts."""
    rows = {path.stem: _nonlinear_row(read_regression(path)) for path in files("nist_nonlinear")}
    title = "NIST nonlinear regressions: digits of the worst parameter (of 11 certified) from start 1 and start 2"
    return DigitTable(title, {name: rows[name] for name in MODELS}) if rows else None


def _nonlinear_row(data: Regression) -> dict[str, float]:
    x, y = nonlinear_data(data)
    model = MODELS[data.name]

    def curve_fit(start: np.ndarray) -> np.ndarray:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            try:
                return optimize.curve_fit(lambda z, *b: model(z, np.array(b)), x, y, p0=start)[0]
            except RuntimeError:  # it says that it did not converge
                return np.full(start.size, np.nan)

    ours = {f"emg2vsa {i}": fit_nonlinear(model, x, y, start).parameters for i, start in enumerate(data.starts, 1)}
    peer = {f"curve_fit {i}": curve_fit(start) for i, start in enumerate(data.starts, 1)}
    return {name: worst(found, data.estimates, CERTIFIED) for name, found in (ours | peer).items()}


def exponential_digits() -> dict[str, float]:
    """Digits of p and q, the worse, of the two sets that are exponentials: DanWood in ln x, MGH10 with b3 given."""
    found: dict[str, float] = {}
    paths: dict[str, Path] = {path.stem: path for path in files("nist_nonlinear")}
    for name in ("DanWood", "MGH10 with b3 given") if paths else ():
        data = read_regression(paths[name.split()[0]])
        x, y = nonlinear_data(data)
        z = np.log(x) if name == "DanWood" else 1 / (x + float(data.estimates[2]))
        fit = fit_exponential(z, y)
        found[name] = worst((fit.y0[0] * np.exp(-fit.q[0] * fit.x0[0]), fit.q[0]), data.estimates[:2])
    return found
