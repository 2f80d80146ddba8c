"""NIST's exponential regressions beside other libraries."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from scipy import optimize

from benchmarks.bench.case import Case, Size, Way
from benchmarks.nist import digits, nist_files, nonlinear_data, read_regression
from emg2vsa.curves.exponential import fit_exponential


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


def worst(found: Iterable[float], certified: tuple[str, ...], cap: float = 15.0) -> float:
    """Digits of the worst of the values."""
    return min(digits(value, truth, cap) for value, truth in zip(found, certified, strict=True))


def _relative(found: Iterable[float], certified: tuple[str, ...]) -> float:
    return float(10 ** -worst(found, certified))
