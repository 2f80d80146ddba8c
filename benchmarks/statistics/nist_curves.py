"""NIST's linear and nonlinear regressions beside other libraries."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

import numpy as np
from scipy import optimize

from benchmarks.bench.case import Case, Size, Way
from benchmarks.nist import (
    LINEAR_DEGREE,
    MODELS,
    Regression,
    digits,
    nist_files,
    nonlinear_data,
    read_regression,
)
from benchmarks.statistics.linear import fit_linear, powers
from benchmarks.statistics.peers import lmfit, statsmodels_api
from emg2vsa.curves.exponential import fit_exponential
from emg2vsa.curves.nonlinear import fit_nonlinear

CERTIFIED = 11.0
"""Digits of NIST's nonlinear values."""
Fitted = list[np.ndarray]
"""Parameters (p,) of every set."""


def nonlinear_cases(size: Size) -> Iterator[Case]:
    """All sets by general least squares, from NIST's two starts."""
    known = {path.stem: read_regression(path) for path in nist_files("nist_nonlinear")}
    sets = [known[name] for name in list(MODELS)[: size.pick(3, None)]]
    for start in (0, 1):
        ways = [
            Way("emg2vsa", "fit_nonlinear", _all(sets, start, _by_ours), "equal"),
            Way("scipy", "curve_fit", _all(sets, start, _by_curve_fit), "equal"),
        ]
        if lmfit is not None:
            ways.append(Way("lmfit", "minimize, leastsq", _all(sets, start, _by_lmfit), "equal"))
        yield Case(
            f"NIST nonlinear regressions from start {start + 1}",
            len(sets),
            "sets",
            tuple(ways),
            lambda found: float(sum(digits_of_set < 6.0 for digits_of_set in _digits(found, sets))),
            "sets with fewer than 6 digits",
            "NIST's certified values, 11 digits",
        )


def linear_cases(size: Size) -> Iterator[Case]:
    """Sets that try least squares on polynomials. emg2vsa fits none of them; this is the solver of its fits."""
    for path in nist_files("nist_linear"):
        if path.stem in size.pick(("Filip",), tuple(LINEAR_DEGREE)):
            yield _linear_case(read_regression(path))


def exponential_cases(size: Size) -> Iterator[Case]:
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
                Way("emg2vsa", "fit_exponential", lambda z=z, y=y: _exponential(z, y), "equal"),
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


def _exponential(z: np.ndarray, y: np.ndarray) -> np.ndarray:
    fit = fit_exponential(z, y)
    return np.array([fit.y0[0] * np.exp(-fit.q[0] * fit.x0[0]), fit.q[0]])


def _curve_fit_exponential(z: np.ndarray, y: np.ndarray) -> np.ndarray:
    slope, intercept = np.polyfit(z, np.log(y), 1)
    start = np.exp(intercept), slope
    return np.asarray(optimize.curve_fit(lambda x, p, q: p * np.exp(q * x), z, y, p0=start, maxfev=10_000)[0])


def _linear_case(data: Regression) -> Case:
    degree = LINEAR_DEGREE[data.name]
    intercept = not data.name.startswith("NoInt")
    text_x = data.x.astype(np.longdouble) if degree is None else powers(data.x[:, 0], degree)
    text_y = data.y.astype(np.longdouble)
    x, y = text_x.astype(np.float64), data.y.astype(np.float64)
    design = np.column_stack([np.ones(y.size), x]) if intercept else x
    note = "the file's own digits"
    ways = [
        Way(
            "emg2vsa",
            "nonlinear.solve, doubles",
            lambda: fit_linear(x, y, intercept=intercept).coefficients[0],
            "equal",
        ),
        Way(
            "emg2vsa",
            "nonlinear.solve, decimal text",
            lambda: fit_linear(text_x, text_y, intercept=intercept).coefficients[0],
            "as used",
            note,
        ),
        Way("numpy", "linalg.lstsq", lambda: np.linalg.lstsq(design, y, rcond=None)[0], "equal"),
    ]
    if statsmodels_api is not None:
        for method in ("pinv", "qr"):
            fit = lambda m=method: statsmodels_api.OLS(y, design).fit(method=m).params  # noqa: E731
            ways.append(Way("statsmodels", f"OLS, {method}", fit, "equal"))
    return Case(
        f"NIST {data.name}",
        y.size,
        "points",
        tuple(ways),
        lambda found: _relative(found, data.estimates),
        "relative",
        "NIST's certified values, 15 digits",
    )


def _all(
    sets: list[Regression], start: int, fit: Callable[[Regression, np.ndarray], np.ndarray]
) -> Callable[[], Fitted]:
    return lambda: [fit(data, data.starts[start]) for data in sets]


def _by_ours(data: Regression, start: np.ndarray) -> np.ndarray:
    x, y = nonlinear_data(data)
    return fit_nonlinear(MODELS[data.name], x, y, start).parameters


def _by_curve_fit(data: Regression, start: np.ndarray) -> np.ndarray:
    x, y = nonlinear_data(data)
    with np.errstate(all="ignore"):
        try:
            return np.asarray(optimize.curve_fit(lambda z, *b: MODELS[data.name](z, np.array(b)), x, y, p0=start)[0])
        except RuntimeError:  # it says that it did not converge
            return np.full(start.size, np.nan)


def _by_lmfit(data: Regression, start: np.ndarray) -> np.ndarray:
    x, y = nonlinear_data(data)
    parameters = lmfit.Parameters()
    for i, value in enumerate(start):
        parameters.add(f"b{i}", value=value)

    def residual(p: dict[str, float]) -> np.ndarray:
        return np.asarray(MODELS[data.name](x, np.array([p[f"b{i}"] for i in range(start.size)])) - y)

    with np.errstate(all="ignore"):
        try:
            found = lmfit.minimize(residual, parameters).params
        except ValueError:  # it gives up at the first value that is not finite
            return np.full(start.size, np.nan)
    return np.array([found[f"b{i}"].value for i in range(start.size)])


def _digits(found: Fitted, sets: list[Regression]) -> list[float]:
    return [worst(values, data.estimates, CERTIFIED) for values, data in zip(found, sets, strict=True)]


def worst(found: Iterable[float], certified: tuple[str, ...], cap: float = 15.0) -> float:
    """Digits of the worst of the values."""
    return min(digits(value, truth, cap) for value, truth in zip(found, certified, strict=True))


def _relative(found: Iterable[float], certified: tuple[str, ...]) -> float:
    return float(10 ** -worst(found, certified))
