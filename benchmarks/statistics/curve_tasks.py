"""700 logarithmic fits, and 2000 exponential ones on resampled data."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pandas as pd
from scipy import optimize, stats

from benchmarks.statistics.exact_curves import exact_exponential, exact_log_fit
from benchmarks.statistics.peers import pingouin, statsmodels_api, statsmodels_formula
from benchmarks.statistics.task import Exact, Numbers, Peer, Task
from emg2vsa.curves.exponential import fit_exponential
from emg2vsa.curves.logarithmic import fit_log

A_V, B_V, NOISE_V = 30e-6, 15e-6, 5e-6
KAPPA, CASR, REPETITION_CV = np.array([7.63, 3.35, 1.11]), np.array([0.186, 0.711, 1.416]), 0.05
LOG_NUMBERS = ("a", "b", "SE(b)", "adj R2")


def curve_tasks(n_fits: int = 700, n_points: int = 131, n_resamples: int = 2000) -> Iterator[Task]:
    """Fits each on its own forces, all on one grid; refits of three means and of thirty points."""
    rng = np.random.default_rng(1)
    grid = np.linspace(0.5, 7, n_points)
    force = np.sort(rng.uniform(0.5, 7, (n_fits, n_points)), axis=1)
    for title, rows in (("each on its own forces", force), ("all on one grid", np.tile(grid, (n_fits, 1)))):
        v = A_V + B_V * np.log(rows) + NOISE_V * rng.standard_normal(rows.shape)
        one_grid = title == "all on one grid"
        yield Task(
            f"{n_fits} logarithmic fits of {n_points} points, {title}",
            lambda x=grid if one_grid else force, v=v: _ours(x, v),
            tuple(_grid_peers(grid, v) if one_grid else _log_peers(rows, v)),
            lambda rows=rows, v=v: _exact_rows(exact_log_fit, rows, v, LOG_NUMBERS),
            None if one_grid else 1.6,
        )
    x = CASR[:, None] * (1 + REPETITION_CV * rng.standard_normal((3, 10)))
    drawn = x[np.arange(3)[:, None], rng.integers(0, 10, (n_resamples, 3, 10))]
    for title, x_rows, y in (
        ("means of three specimens", drawn.mean(axis=2), KAPPA),
        ("thirty points", drawn.reshape(n_resamples, 30), np.repeat(KAPPA, 10)),
    ):
        yield _refits(f"{n_resamples} bootstrap refits of kappa = p exp(q CASR), {title}", x_rows, y)


def _ours(x: np.ndarray, v: np.ndarray) -> Numbers:
    fit = fit_log(x, v)
    return {"a": fit.a, "b": fit.b, "SE(b)": fit.b_se, "adj R2": fit.adj_r2}


def _exact_rows(exact: Callable[..., Any], x: np.ndarray, y: np.ndarray, names: tuple[str, ...], n: int = 20) -> Exact:
    """The worst of n rows stands for all."""
    rows = {i: exact(x[i], y[i]) for i in range(0, len(x), max(1, len(x) // n))}
    return {name: {i: found[name] for i, found in rows.items()} for name in names}


def _columns(rows: list[tuple[float, ...]], names: tuple[str, ...] = LOG_NUMBERS) -> Numbers:
    return dict(zip(names, np.array(rows).T, strict=True))


def _log_peers(force: np.ndarray, v: np.ndarray) -> Iterator[Peer]:
    def each(fit: Callable[[np.ndarray, np.ndarray], tuple[float, ...]], *names: str) -> Callable[[], Numbers]:
        return lambda: _columns([fit(np.log(f), y) for f, y in zip(force, v, strict=True)], names or LOG_NUMBERS)

    def linregress(x: np.ndarray, y: np.ndarray) -> tuple[float, ...]:
        fit = stats.linregress(x, y)
        return fit.intercept, fit.slope, fit.stderr, 1 - (1 - fit.rvalue**2) * (x.size - 1) / (x.size - 2)

    def curve_fit(x: np.ndarray, y: np.ndarray) -> tuple[float, ...]:
        (a, b), covariance = optimize.curve_fit(lambda z, p, q: p + q * z, x, y)
        return a, b, np.sqrt(covariance[1, 1])

    yield Peer("np.polyfit, loop", each(lambda x, y: tuple(np.polyfit(x, y, 1)[::-1]), "a", "b"), (36, 58))
    yield Peer("scipy linregress, loop", each(linregress), (376, 599))
    yield Peer("scipy curve_fit, loop", each(curve_fit, "a", "b", "SE(b)"), (237, 378))
    if statsmodels_api is not None:
        yield Peer("statsmodels OLS, loop", each(_ols), (366, 583))
        yield Peer("statsmodels formula ols, loop", each(_formula_ols), (2994, 4767))
    if pingouin is not None:
        yield Peer("pingouin linear_regression, loop", each(_pingouin), (586, 933))


def _ols(x: np.ndarray, y: np.ndarray) -> tuple[float, ...]:
    fit = statsmodels_api.OLS(y, np.column_stack([np.ones(x.size), x])).fit()
    return *fit.params, fit.bse[1], fit.rsquared_adj


def _formula_ols(x: np.ndarray, y: np.ndarray) -> tuple[float, ...]:
    fit = statsmodels_formula.ols("y ~ x", pd.DataFrame({"x": x, "y": y})).fit()
    return fit.params["Intercept"], fit.params["x"], fit.bse["x"], fit.rsquared_adj


def _pingouin(x: np.ndarray, y: np.ndarray) -> tuple[float, ...]:
    fit = pingouin.linear_regression(x, y, as_dataframe=False)
    return *fit["coef"], fit["se"][1], fit["adj_r2"]


def _grid_peers(grid: np.ndarray, v: np.ndarray) -> Iterator[Peer]:
    def lstsq() -> Numbers:
        columns = np.column_stack([np.ones(grid.size), np.log(grid)])
        coefficients, residual, _, _ = np.linalg.lstsq(columns, v.T, rcond=None)
        left = residual / np.sum((v - v.mean(axis=1, keepdims=True)) ** 2, axis=1)
        return {
            "a": coefficients[0],
            "b": coefficients[1],
            "SE(b)": np.sqrt(residual / (grid.size - 2) * np.linalg.inv(columns.T @ columns)[1, 1]),
            "adj R2": 1 - left * (grid.size - 1) / (grid.size - 2),
        }

    yield Peer("np.linalg.lstsq, all in one call", lstsq)


def _refits(title: str, x: np.ndarray, y: np.ndarray) -> Task:
    names = ("p", "q")

    def ours() -> Numbers:
        fit = fit_exponential(x, np.broadcast_to(y, x.shape))
        return {"p": fit.y0 * np.exp(-fit.q * fit.x0), "q": fit.q}

    def curve_fit() -> Numbers:
        rows = []
        for row in x:
            rows.append(optimize.curve_fit(lambda z, p, q: p * np.exp(q * z), row, y, p0=(8.0, -1.0))[0])
        return _columns(rows, names)

    peers = (Peer("scipy curve_fit, good start, loop", curve_fit, (75, 948)),)
    return Task(title, ours, peers, lambda: _exact_rows(exact_exponential, x, np.broadcast_to(y, x.shape), names), 12.6)
