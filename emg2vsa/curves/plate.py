"""Stiffness of a specimen from indenting it with a plate (paper IV.B): moving average, then F = kappa (x - x0).

Contact is where the curve leaves its rest: one level, then one straight line that starts from it. Many trials at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from casr.counts import count
from emg2vsa.arrays import Floats, Ints, exponent_of
from emg2vsa.curves.force_range import loading
from emg2vsa.curves.line import fit_line, weighted_rows
from emg2vsa.errors import SettingError
from emg2vsa.shown import shown

_LEAST_POINTS = 3
"""Fewest points of the line behind the hinge."""
_PRICE = 3.0  # times ln n, of a change whose place was searched for (Zhang and Siegmund 2007); at 2 one in 200 is false
PAPER_WINDOW = 5
"""Samples of the paper's moving average."""


def _hinge(x: Floats, y: Floats, count: Ints) -> Ints:
    """Number of points (d,) before the hinge; 0 where one line through all points says as much.

    x, y : (d, n), finite, x rising along each row; count : (d,) points of each row that count, the first ones. Least
    squares of level + slope max(0, x - x_j) for every x_j at once by running sums, slope > 0. The hinge must earn
    its place by a Bayesian information criterion.
    """
    if x.shape[1] == 0:
        return np.zeros(len(x), dtype=np.int64)
    index = np.arange(x.shape[1])
    there, n = index < count[:, None], np.maximum(count, 1)[:, None]
    x = np.where(there, x - np.sum(x, axis=1, keepdims=True, where=there) / n, 0.0)
    y = np.where(there, y - np.sum(y, axis=1, keepdims=True, where=there) / n, 0.0)
    behind = np.maximum(count[:, None] - index - 1, 0)  # x_j itself stands before
    with np.errstate(divide="ignore", invalid="ignore"):
        sum_x = _behind(x)
        arm = sum_x - behind * x  # sums of max(0, x - x_j), of its square and its product with y
        arm_arm = _behind(x * x) - 2 * x * sum_x + behind * x * x
        arm_y = _behind(x * y) - x * _behind(y)
        slope = arm_y / (arm_arm - arm * arm / n)
        size = np.sum(y * y, axis=1)
        gain = np.where((behind >= _LEAST_POINTS) & (slope > 0), slope * arm_y, -np.inf)
        of_line = np.sum(x * y, axis=1) ** 2 / np.sum(x * x, axis=1)
        best = np.argmax(gain, axis=1)
        left, left_of_line = size - np.take_along_axis(gain, best[:, None], axis=1)[:, 0], size - of_line
        floor = size * np.finfo(np.float64).eps * count
        earned = left_of_line > np.maximum(left, floor) * count ** (_PRICE / np.maximum(count, 1))
    return np.where(earned & (best > 0), best + 1, 0)


def _behind(values: Floats) -> Floats:
    """Sum (d, n) of the values behind each point, itself left out."""
    return np.asarray(np.cumsum(values[:, ::-1], axis=1)[:, ::-1] - values)


@dataclass(frozen=True)
class HookeFit:
    """d trials; every field (d,), NaN where undefined.

    kappa, kappa_se : force over indentation (N/mm). contact : indentation at which the line leaves the force of rest,
    x0. adj_r2 : of the line, over the points in contact; a parabola from contact on has .94. n_rest, n : points before
    contact and in contact.
    The standard errors take points as independent: filtered samples are not, and then they are too small.
    """

    kappa: Floats = field(metadata=shown("κ (N/mm)", digits=4))
    kappa_se: Floats = field(metadata=shown("Standard error (N/mm)", digits=2))
    contact: Floats = field(metadata=shown("Contact (mm)"))
    adj_r2: Floats = field(metadata=shown("adj. R²", digits=4))
    n_rest: Ints
    n: Ints = field(metadata=shown("Points in contact"))


def fit_hooke(indentation: ArrayLike, force: ArrayLike) -> HookeFit:
    """Fit the loading phase of each trial, filtered as the caller wants it (the paper: a five-point moving average).

    indentation : (n,) or (d, n), e.g. mm, into the specimen; force : (n,) or (d, n), e.g. N, compression positive. NaN
    pads short trials; the order of points does not matter. The contact is found: points before it lie about one level,
    those behind it about a line that leaves this level (``_hinge``). A specimen that stiffens as it is pressed has no
    single kappa; its line starts late, which adj_r2 hardly tells: ``force_range`` does. DataError where the shapes do
    not fit.
    """
    rows = weighted_rows(indentation, force, None, where="Hooke fit")
    order = np.argsort(np.where(rows.w > 0, rows.x, np.inf), axis=1, kind="stable")
    x, y, w = (np.take_along_axis(values, order, axis=1) for values in (rows.x, rows.y, rows.w))
    unit_x, unit_y = exponent_of(x), exponent_of(y)
    x, y = np.ldexp(x, -unit_x), np.ldexp(y, -unit_y)
    n_rest = _hinge(x, y, rows.n)
    w = np.where(np.arange(x.shape[1]) < n_rest[:, None], 0.0, w)
    resting = np.arange(x.shape[1]) < n_rest[:, None]
    line = fit_line(x, y, w)
    count("fits", len(y))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        rest = np.where(n_rest > 0, np.sum(y, axis=1, where=resting) / n_rest, 0.0)
        contact = (rest - line.intercept) / line.slope
        unit = (unit_y - unit_x)[:, 0]
        return HookeFit(
            kappa=np.ldexp(line.slope, unit),
            kappa_se=np.ldexp(line.slope_se, unit),
            contact=np.ldexp(contact, unit_x[:, 0]),
            adj_r2=line.adj_r2,
            n_rest=n_rest,
            n=line.n,
        )


def fit_plate(trials: Sequence[tuple[Floats, Floats]], window: int = PAPER_WINDOW) -> HookeFit:
    """Fit every trial up to its deepest point, smoothed; d trials of (n,) indentation, mm, and (n,) force, N.

    Both are averaged over ``window`` samples, so that neither lags the other. What comes after the deepest point is
    unloading, where a viscous specimen is softer.

    Raises
    ------
    SettingError : a window below 1.
    The line is that of paper IV.B; where it begins has the price of Zhang and Siegmund (2007).
    """
    if window < 1:
        raise SettingError("window", wanted="1 sample or more", found=str(window), do="Use 5, as in the paper.")
    smooth = [smoothed(*trial, window) for trial in trials]
    longest = max((x.size for x, _ in smooth), default=0)
    padded = np.full((2, len(smooth), longest), np.nan)
    for row, (x, y) in enumerate(smooth):
        padded[0, row, : x.size], padded[1, row, : y.size] = x, y
    return fit_hooke(padded[0], padded[1])


def smoothed(indentation_mm: Floats, force_n: Floats, window: int = PAPER_WINDOW) -> tuple[Floats, Floats]:
    """(n,) of a trial up to its deepest point, both averaged over ``window`` samples."""
    x, y, _ = loading(indentation_mm, force_n)
    return _averaged(x, window), _averaged(y, window)


def _averaged(values: Floats, window: int) -> Floats:
    if values.size < window:
        return np.empty(0)
    return np.convolve(values, np.full(window, 1 / window), mode="valid")
