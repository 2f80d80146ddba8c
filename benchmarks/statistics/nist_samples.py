"""NIST's analyses of variance and summary statistics: digits beside other libraries."""

from __future__ import annotations

import re
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from benchmarks.nist import digits
from benchmarks.statistics.digit_table import DigitTable, files
from benchmarks.statistics.exact_tests import f_statistic, fractions, mpq
from benchmarks.statistics.peers import pingouin, statsmodels_api, statsmodels_formula
from emg2vsa.curves.press_fits import autocorrelation
from emg2vsa.statistics.anova import one_way
from emg2vsa.statistics.moments import group_moments

OURS, FROM_TEXT, CEILING = "emg2vsa", "from decimal text", "doubles allow"


def anova_table() -> DigitTable | None:
    """Digits of F."""
    rows = {path.stem: _anova_row(path) for path in files("nist_anova")}
    return DigitTable("NIST analyses of variance: digits of F", rows) if rows else None


def _anova_row(path: Path) -> dict[str, float]:
    lines = path.read_text().splitlines()
    groups: dict[str, list[str]] = {}
    for group, value in (line.split() for line in lines[60:] if len(line.split()) == 2):
        groups.setdefault(group, []).append(value)
    certified = next(line.split()[-1] for line in lines[40:60] if line.startswith("Between"))
    text = list(groups.values())
    doubles = np.array(text, dtype=np.float64)
    f = {
        OURS: one_way(doubles).f[0],
        FROM_TEXT: one_way([[Decimal(value) for value in group] for group in text]).f[0],
        CEILING: float(mpq(f_statistic(fractions(doubles))[0])),
        "scipy": stats.f_oneway(*doubles).statistic,
        **_anova_peers(doubles),
    }
    return {name: digits(value, certified) for name, value in f.items()}


def _anova_peers(doubles: np.ndarray) -> dict[str, Any]:
    table = pd.DataFrame({"y": doubles.ravel(), "g": np.repeat(np.arange(len(doubles)), doubles.shape[1])})
    f = {}
    if statsmodels_api is not None:
        fit = statsmodels_formula.ols("y ~ C(g)", table).fit()
        f["anova_lm"] = statsmodels_api.stats.anova_lm(fit)["F"].iloc[0]
        f["anova_oneway"] = statsmodels_api.stats.anova_oneway(list(doubles), use_var="equal").statistic
    if pingouin is not None:
        f["pingouin"] = pingouin.anova(table, dv="y", between="g")["F"].iloc[0]
    return f


def univariate_table() -> DigitTable | None:
    """Digits of mean, SD and lag-1 autocorrelation."""
    rows = {path.stem: _univariate_row(path) for path in files("nist_univariate")}
    title = "NIST summary statistics: digits of mean, SD, lag-1 autocorrelation (np, sm: NumPy, statsmodels)"
    return DigitTable(title, rows) if rows else None


def _univariate_row(path: Path) -> dict[str, float]:
    head, data = re.split(r"Data: Y\s*-+\s*", path.read_text())
    text = data.split()
    mean, sd, r1 = re.findall(r"^Sample .*: +(\S+)", head, re.MULTILINE)
    y = np.array(text, dtype=np.float64)
    exact = np.array([[[Decimal(value) for value in text]]], dtype=object)
    (own_mean, own_sd), (text_mean, text_sd) = _moments(y[None, None]), _moments(exact)
    found = {
        "mean": (own_mean, mean),
        "text mean": (text_mean, mean),
        "np mean": (y.mean(), mean),
        "SD": (own_sd, sd),
        "text SD": (text_sd, sd),
        "np SD": (y.std(ddof=1), sd),
        "r1": (autocorrelation(y[None])[0, 1], r1),
    }
    if statsmodels_api is not None:
        found["sm r1"] = (statsmodels_api.tsa.acf(y, nlags=1, fft=False)[1], r1)
    return {name: digits(value, certified) for name, (value, certified) in found.items()}


def _moments(values: np.ndarray) -> tuple[float, float]:
    groups = group_moments(values)
    return groups.mean[0, 0], groups.to_data(np.sqrt(groups.squares / (groups.count - 1)))[0, 0]
