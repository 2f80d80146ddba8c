"""700 logarithmic fits, and 2000 exponential ones on resampled data; NIST's exponential regressions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np
from mpmath import mp
from scipy import optimize, stats

from benchmarks.bench.case import Case, Size, Way, peer
from benchmarks.experts import curves
from benchmarks.nist import (
    Numbers,
    columns,
    digits,
    exact_rows,
    nist_files,
    nonlinear_data,
    read_regression,
    worst_error,
)
from benchmarks.stress.exact_curves import exact_exponential, exact_line, mpfs
from emg2vsa.curves.exponential import fit_exponential
from emg2vsa.curves.logarithmic import fit_log

A_V, B_V, NOISE_V = 30e-6, 15e-6, 5e-6
KAPPA, CASR, REPETITION_CV = np.array([7.63, 3.35, 1.11]), np.array([0.186, 0.711, 1.416]), 0.05
LOG_NUMBERS = ("a", "b", "SE(a)", "SE(b)", "adj R2")
MPMATH = "50-digit arithmetic"
EXP_FLOPS = 20
"Of one logarithm or exponential of a double, by a polynomial."
statsmodels_api = peer("statsmodels.api")


def log_cases(size: Size) -> Iterator[Case]:
    """Fits of v = a + b log F, each on its own forces, and all on one grid."""
    rng = np.random.default_rng(1)
    n_points = 131
    for n_fits in size.pick((5, 10), (70, 700, 7000)):
        force = np.sort(rng.uniform(0.5, 7, (n_fits, n_points)), axis=1)
        family = "logarithmic fits of 131 points, each on its own forces"
        v = _noisy(force, rng)
        ways = (
            Way("emg2vsa", "fit_log", lambda x=force, v=v: _ours(x, v), "equal"),
            *_log_peers(force, v, n_fits <= 700),
        )
        name = f"{family}, {n_fits} fits"
        least = 8.0 * (2 * v.size + 9 * len(v)), (EXP_FLOPS + 10.0) * v.size
        yield Case(name, n_fits, "fits", ways, _log_error(force, v), "relative", MPMATH, family, *least)
    grid = np.linspace(0.5, 7, n_points)
    rows = np.tile(grid, (size.pick(10, 700), 1))
    v = _noisy(rows, rng)
    ways = (Way("emg2vsa", "fit_log", lambda: _ours(grid, v), "equal"), *_grid_peers(grid, v))
    name = f"logarithmic fits of 131 points, all on one grid, {len(v)} fits"
    least = 8.0 * (v.size + 9 * len(v)), 6.0 * v.size
    yield Case(name, len(v), "fits", ways, _log_error(rows, v), "relative", MPMATH, "", *least)


def exponential_cases(size: Size) -> Iterator[Case]:
    """Refits of kappa = p exp(q CASR), as a bootstrap makes them."""
    rng = np.random.default_rng(1)
    x = CASR[:, None] * (1 + REPETITION_CV * rng.standard_normal((3, 10)))
    for n_resamples in size.pick((10, 20), (200, 2000, 20_000)):
        drawn = x[np.arange(3)[:, None], rng.integers(0, 10, (n_resamples, 3, 10))]
        family = "bootstrap refits of an exponential, thirty points"
        points, y = drawn.reshape(n_resamples, 30), np.repeat(KAPPA, 10)
        yield _refits(f"{family}, {n_resamples} refits", points, y, family, loops=n_resamples <= 2000)
        if n_resamples == size.pick(20, 2000):
            name = f"bootstrap refits of an exponential, means of three specimens, {n_resamples} refits"
            yield _refits(name, drawn.mean(axis=2), KAPPA)


def _noisy(force: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return np.asarray(A_V + B_V * np.log(force) + NOISE_V * rng.standard_normal(force.shape))


def _log_error(force: np.ndarray, v: np.ndarray) -> Callable[[Numbers], float]:
    return worst_error(lambda: exact_rows(_exact_log_fit, LOG_NUMBERS, force, v))


def _ours(x: np.ndarray, v: np.ndarray) -> Numbers:
    fit = fit_log(x, v)
    return {"a": fit.a, "b": fit.b, "SE(a)": fit.a_se, "SE(b)": fit.b_se, "adj R2": fit.adj_r2}


def _log_peers(force: np.ndarray, v: np.ndarray, few: bool) -> Iterator[Way]:
    """few : so few fits that loops over slow libraries end in seconds."""

    def each(fit: Callable[[np.ndarray, np.ndarray], tuple[float, ...]], *names: str) -> Callable[[], Numbers]:
        return lambda: columns([fit(np.log(f), y) for f, y in zip(force, v, strict=True)], names or LOG_NUMBERS)

    def linregress(x: np.ndarray, y: np.ndarray) -> tuple[float, ...]:
        fit = stats.linregress(x, y)
        adjusted = 1 - (1 - fit.rvalue**2) * (x.size - 1) / (x.size - 2)
        return fit.intercept, fit.slope, fit.intercept_stderr, fit.stderr, adjusted

    yield Way("numpy", "expert: closed form", lambda: curves.log_fits(force, v), "equal")
    if not few:
        return
    yield Way("numpy", "expert: batched QR", lambda: curves.log_fits_by_qr(force, v), "equal")
    yield Way("scipy", "linregress, loop", each(linregress), "equal")
    if statsmodels_api is not None:
        yield Way("statsmodels", "OLS, loop", each(_ols), "equal")


def _ols(x: np.ndarray, y: np.ndarray) -> tuple[float, ...]:
    fit = statsmodels_api.OLS(y, np.column_stack([np.ones(x.size), x])).fit()
    return *fit.params, *fit.bse, fit.rsquared_adj


def _grid_peers(grid: np.ndarray, v: np.ndarray) -> Iterator[Way]:
    yield Way("numpy", "expert: one product for all", lambda: curves.log_fits_on_a_grid(grid, v), "equal")


def _refits(name: str, x: np.ndarray, y: np.ndarray, family: str = "", loops: bool = True) -> Case:
    names = ("p", "q")

    def ours() -> Numbers:
        fit = fit_exponential(x, np.broadcast_to(y, x.shape))
        return {"p": fit.y0 * np.exp(-fit.q * fit.x0), "q": fit.q}

    def curve_fit() -> Numbers:
        def each(row: np.ndarray) -> tuple[float, ...]:
            return tuple(optimize.curve_fit(lambda z, p, q: p * np.exp(q * z), row, y, p0=(8.0, -1.0))[0])

        return columns([each(row) for row in x], names)

    ways = [
        Way("emg2vsa", "fit_exponential, all in one call", ours, "equal"),
        Way("numpy", "expert: p eliminated, Newton's steps", lambda: curves.exponential_fits(x, y), "equal"),
    ]
    if loops:
        ways.append(Way("scipy", "curve_fit, good start, loop", curve_fit, "equal"))
    rows = np.broadcast_to(y, x.shape)
    error = worst_error(lambda: exact_rows(_exact_exponential, names, x, rows, most=2 if len(x) < 100 else 20))
    moved, flops = 8.0 * (x.size + 2 * len(x)), 3 * (EXP_FLOPS + 12) * float(x.size)
    return Case(name, len(x), "refits", tuple(ways), error, "relative", MPMATH, family, moved, flops)


def _exact_log_fit(force: np.ndarray, v: np.ndarray) -> dict[str, Any]:
    fit = exact_line([mp.log(each) for each in mpfs(force)], mpfs(v))
    return fit | {"adj R2": 1 - (1 - fit["R2"]) * (len(v) - 1) / (len(v) - 2)}


def _exact_exponential(x: np.ndarray, y: np.ndarray) -> dict[str, Any]:
    """p exp(q x)."""
    fit = exact_exponential(mpfs(x), mpfs(y))
    return {"p": fit["level"] * mp.exp(-fit["q"] * fit["centre"]), "q": fit["q"]}


def nist_exponential_cases(size: Size) -> Iterator[Case]:
    """The two sets that are exponentials: DanWood in ln x, MGH10 with b3 given."""
    known = {path.stem: path for path in nist_files("nist_nonlinear")}
    for name in ("DanWood", "MGH10"):
        data = read_regression(known[name])
        x, y = nonlinear_data(data)
        z = np.log(x) if name == "DanWood" else 1 / (x + float(data.estimates[2]))
        yield Case(
            f"NIST {name} as an exponential",
            y.size,
            "points",
            (
                Way("emg2vsa", "fit_exponential", lambda z=z, y=y: _fitted(z, y), "equal"),
                Way(
                    "scipy",
                    "curve_fit from the logarithmic line",
                    lambda z=z, y=y: _curve_fit_exponential(z, y),
                    "equal",
                ),
            ),
            lambda found, data=data: _relative(found, data.estimates[:2]),
            "relative",
            "NIST's certified values, 11 digits",
        )


def _fitted(z: np.ndarray, y: np.ndarray) -> np.ndarray:
    fit = fit_exponential(z, y)
    return np.array([fit.y0[0] * np.exp(-fit.q[0] * fit.x0[0]), fit.q[0]])


def _curve_fit_exponential(z: np.ndarray, y: np.ndarray) -> np.ndarray:
    slope, intercept = np.polyfit(z, np.log(y), 1)
    start = np.exp(intercept), slope
    return np.asarray(optimize.curve_fit(lambda x, p, q: p * np.exp(q * x), z, y, p0=start, maxfev=10_000)[0])


def _relative(found: Iterable[float], certified: tuple[str, ...]) -> float:
    """Of the worst of the values."""
    return float(10 ** -min(digits(value, truth) for value, truth in zip(found, certified, strict=True)))
