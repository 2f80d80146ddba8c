"""Normality of 70 samples of ten: Kolmogorov-Smirnov with its exact p, Lilliefors, Shapiro-Wilk.

NIST's analyses of variance.

Intervals of b on simulated presses: what the choices of points and weights promise, and what they hold.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from decimal import Decimal
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from mpmath import mpf
from scipy import signal, special, stats

from benchmarks.bench.case import Case, Size, Way, peer
from benchmarks.nist import Exact, Numbers, digits, exact_rows, nist_files, worst_error
from benchmarks.stress import exact_tests
from benchmarks.stress.exact_curves import mpfs
from emg2vsa.curves.force_bins import bin_edges
from emg2vsa.curves.press_fits import fit_presses
from emg2vsa.settings import FitSettings
from emg2vsa.statistics.anova import one_way
from emg2vsa.statistics.lilliefors import lilliefors
from emg2vsa.statistics.normality import ks_normal, shapiro_wilk

statsmodels_api, statsmodels_formula = peer("statsmodels.api"), peer("statsmodels.formula.api")


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
    return digits(float(exact_tests.anova(exact_tests.groups_of(np.array(text, dtype=np.float64)))["F"]), certified)


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

        yield Way("statsmodels", "anova_lm", anova_lm, "equal")


A_V, B_V = 30e-6, 15e-6
FS_HZ, DURATION_S = 1000, 2.5
WAYS = {
    "bins, weighted (default)": FitSettings(),
    "bins, robust": FitSettings(robust=True),
    "bins, unweighted": FitSettings(weights="none"),
    "samples at 100 Hz": FitSettings(points="samples", weights="none"),
}
Interval = tuple[np.ndarray, np.ndarray]
"Low and high of b, V, one press each."


def coverage_cases(size: Size) -> Iterator[Case]:
    """Envelopes of Gaussian carriers on a ramp of force, whose samples are correlated."""
    n = size.pick(20, 1000)
    force_n, v = simulate(n)
    slow_n, slow_v = force_n[:, ::10], v[:, ::10]
    ways = [
        Way("emg2vsa", f"fit_presses, {name}", _fitted(slow_n, slow_v, settings), "equal")
        for name, settings in WAYS.items()
    ]
    ways.append(Way("scipy", "linregress on samples at 1000 Hz, loop", lambda: _linregress(force_n, v), "as used"))
    chance = 100 * np.sqrt(0.95 * 0.05 / n)
    yield Case(
        f"95 % intervals of b of {n} presses",
        n,
        "presses",
        tuple(ways),
        _coverage_error,
        "points of coverage off 95 %",
        f"how many of {n} intervals hold the true b; chance alone is {chance:.1f} points",
    )


def simulate(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Force (n, 2500) and activity of presses of 2.5 s: carriers of two muscles, 60 to 40, FIR envelope, no noise."""
    rng = np.random.default_rng(3)
    n_samples, edge = int(DURATION_S * FS_HZ), FS_HZ // 2
    force_n = 0.5 + 6.5 * np.arange(-edge, n_samples + edge) / (n_samples - 1)
    level_v = A_V + B_V * np.log(np.maximum(force_n, 0.2))
    taps = signal.firwin(51, 20, fs=FS_HZ)
    spectrum = signal.butter(2, (20, 150), "bandpass", fs=FS_HZ, output="sos")
    v = np.zeros((n, level_v.size))
    for share in (0.4, 0.6):
        carrier = signal.sosfilt(spectrum, rng.standard_normal((n, level_v.size + FS_HZ)), axis=1)[:, FS_HZ:]
        emg = share * level_v * carrier / carrier.std()
        v += np.sqrt(np.pi / 2) * signal.oaconvolve(np.abs(emg), taps[None], mode="same", axes=1)
    return np.tile(force_n[edge:-edge], (n, 1)), v[:, edge:-edge]


def _fitted(force_n: np.ndarray, v: np.ndarray, settings: FitSettings) -> Callable[[], Interval]:
    flat_n, flat_v, offsets = force_n.ravel(), v.ravel(), np.arange(len(v) + 1) * v.shape[1]
    edges = bin_edges(0.5, 7, 0.3)

    def run() -> Interval:
        found = fit_presses(flat_n, flat_v, offsets, edges, settings).reported
        return found.b_lo, found.b_hi

    return run


def _linregress(force_n: np.ndarray, v: np.ndarray) -> Interval:
    fits = [stats.linregress(np.log(x), y) for x, y in zip(force_n, v, strict=True)]
    reach = stats.t.ppf(0.975, v.shape[1] - 2) * np.array([fit.stderr for fit in fits])
    slope = np.array([fit.slope for fit in fits])
    return slope - reach, slope + reach


def _coverage_error(found: Interval) -> float:
    low, high = found
    return 100 * abs(float(np.mean((low < B_V) & (high > B_V))) - 0.95)


MPMATH = "50-digit arithmetic"


def sample_cases(size: Size) -> Iterator[Case]:
    """Normality of samples of ten."""
    rows = np.random.default_rng(2).standard_normal((size.pick(6, 70), 10))
    rows[::3] = np.exp(rows[::3])
    simulated = size.pick(20_000, 2_000_000)
    for title, ours, peers, exact, truth in (
        (
            "Kolmogorov-Smirnov, standardised, exact p",
            lambda: _ours(ks_normal(rows, standardise=True), "D"),
            _ks_peers,
            lambda: exact_rows(lambda row: exact_tests.ks(mpfs(row)), ("D", "p"), rows),
            MPMATH,
        ),
        (
            "Lilliefors",
            lambda: _ours(lilliefors(rows), "D"),
            _lilliefors_peers,
            lambda: _simulated_p(rows, simulated),
            f"p of {simulated:.0e} simulated samples, to 2 or 3 digits",
        ),
        (
            "Shapiro-Wilk",
            lambda: _ours(shapiro_wilk(rows), "W"),
            _shapiro_peers,
            lambda: exact_rows(lambda row: exact_tests.shapiro(mpfs(row)), ("W", "p"), rows),
            MPMATH + ", Royston's AS R94",
        ),
    ):
        yield Case(
            f"{title}, {len(rows)} samples of 10",
            len(rows),
            "samples",
            (Way("emg2vsa", "all samples in one call", ours, "equal"), *peers(rows)),
            worst_error(exact),
            "relative",
            truth,
        )


def _ours(found: Any, statistic: str) -> Numbers:
    return {statistic: found.statistic, "p": found.p}


def _simulated_p(rows: np.ndarray, simulated: int) -> Exact:
    """p of the first rows' D among those of normal samples, mean and SD estimated."""
    rng, n = np.random.default_rng(4), rows.shape[1]
    found = _largest_gap(rows[:6])
    reached = np.zeros(len(found))
    for _ in range(0, simulated, 100_000):
        d = _largest_gap(rng.standard_normal((min(simulated, 100_000), n)))
        reached += np.count_nonzero(d[:, None] >= found, axis=0)
    drawn = min(simulated, 100_000) * len(range(0, simulated, 100_000))
    return {"p": {i: mpf(int(count)) / drawn for i, count in enumerate(reached)}}


def _largest_gap(rows: np.ndarray) -> np.ndarray:
    n = rows.shape[1]
    cdf = special.ndtr(np.sort(_standardised(rows), axis=1))
    return np.max(np.maximum(np.arange(1, n + 1) / n - cdf, cdf - np.arange(n) / n), axis=1)


def _standardised(rows: np.ndarray) -> np.ndarray:
    return np.asarray((rows - rows.mean(axis=1, keepdims=True)) / rows.std(axis=1, ddof=1, keepdims=True))


def _each(test: Callable[[np.ndarray], Any], statistic: str, rows: np.ndarray) -> Numbers:
    """A test that returns its statistic and p, row by row."""
    return dict(zip((statistic, "p"), np.array([test(row) for row in rows]).T, strict=True))


def _ks_peers(rows: np.ndarray) -> Iterator[Way]:
    def axis_aware() -> Numbers:
        found = stats.ks_1samp(_standardised(rows), stats.norm.cdf, axis=1)
        return {"D": found.statistic, "p": found.pvalue}

    yield Way("scipy", "ks_1samp, axis-aware", axis_aware, "equal")
    looped = partial(_each, lambda z: stats.kstest(z, "norm"), "D")
    yield Way("scipy", "kstest, loop", lambda: looped(_standardised(rows)), "equal")


def _lilliefors_peers(rows: np.ndarray) -> Iterator[Way]:
    if statsmodels_api is not None:
        looped = partial(_each, statsmodels_api.stats.lilliefors, "D", rows)
        yield Way("statsmodels", "lilliefors, loop", looped, "equal")


def _shapiro_peers(rows: np.ndarray) -> Iterator[Way]:
    def axis_aware() -> Numbers:
        found = stats.shapiro(rows, axis=1)
        return {"W": found.statistic, "p": found.pvalue}

    yield Way("scipy", "shapiro, axis given", axis_aware, "equal")
    yield Way("scipy", "shapiro, loop", partial(_each, stats.shapiro, "W", rows), "equal")
