"""NIST's analyses of variance."""

from __future__ import annotations

from collections.abc import Iterator
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from benchmarks.bench.case import Case, Size, Way
from benchmarks.nist import digits, nist_files
from benchmarks.statistics.exact_tests import f_statistic, fractions, mpq
from benchmarks.statistics.peers import pingouin, statsmodels_api, statsmodels_formula
from emg2vsa.stats.anova import one_way


def anova_cases(size: Size) -> Iterator[Case]:
    """One case for each set; the error is that of F. NotHere where NIST's data are absent."""
    for path in nist_files("nist_anova")[: size.pick(2, None)]:
        yield _anova_case(path)


def _anova_case(path: Path) -> Case:
    text, certified = _read(path)
    decimals = [[Decimal(value) for value in group] for group in text]
    doubles = np.array(text, dtype=np.float64)
    ways = (
        Way("emg2vsa", "one_way, doubles", lambda: one_way(doubles).f[0], "equal"),
        Way("emg2vsa", "one_way, decimal text", lambda: one_way(decimals).f[0], "as used", "the file's own digits"),
        Way("scipy", "f_oneway", lambda: stats.f_oneway(*doubles).statistic, "equal"),
        *_anova_peers(doubles),
    )
    truth = f"NIST's certified F; the data as doubles allow {digits_allowed(path):.1f} digits"
    return Case(
        f"NIST {path.stem}", doubles.size, "values", ways, lambda f: 10 ** -digits(f, certified), "relative", truth
    )


def digits_allowed(path: Path) -> float:
    """Digits of F that are left when the data of a set are rounded to doubles, all else exact."""
    text, certified = _read(path)
    return digits(float(mpq(f_statistic(fractions(np.array(text, dtype=np.float64)))[0])), certified)


def _read(path: Path) -> tuple[list[list[str]], str]:
    """Values of each group as text, and the certified F."""
    lines = path.read_text().splitlines()
    groups: dict[str, list[str]] = {}
    for group, value in (line.split() for line in lines[60:] if len(line.split()) == 2):
        groups.setdefault(group, []).append(value)
    return list(groups.values()), next(line.split()[-1] for line in lines[40:60] if line.startswith("Between"))


def _anova_peers(doubles: np.ndarray) -> Iterator[Way]:
    table = pd.DataFrame({"y": doubles.ravel(), "g": np.repeat(np.arange(len(doubles)), doubles.shape[1])})
    if statsmodels_api is not None:

        def anova_lm() -> Any:
            return statsmodels_api.stats.anova_lm(statsmodels_formula.ols("y ~ C(g)", table).fit())["F"].iloc[0]

        def anova_oneway() -> Any:
            return statsmodels_api.stats.anova_oneway(list(doubles), use_var="equal").statistic

        yield Way("statsmodels", "anova_lm", anova_lm, "equal")
        yield Way("statsmodels", "anova_oneway", anova_oneway, "equal")
    if pingouin is not None:
        yield Way("pingouin", "anova", lambda: pingouin.anova(table, dv="y", between="g")["F"].iloc[0], "equal")
