"""Where a curve leaves its rest: one level, then one straight line that starts from it; many curves at once."""

from __future__ import annotations

import numpy as np

from emg2vsa.arrays import Floats, Ints

LEAST_POINTS = 3
"""Fewest points of the line behind the hinge."""
_PRICE = 3.0  # times ln n, of a change whose place was searched for (Zhang and Siegmund 2007); at 2 one in 200 is false


def hinge(x: Floats, y: Floats, count: Ints) -> Ints:
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
        gain = np.where((behind >= LEAST_POINTS) & (slope > 0), slope * arm_y, -np.inf)
        of_line = np.sum(x * y, axis=1) ** 2 / np.sum(x * x, axis=1)
        best = np.argmax(gain, axis=1)
        left, left_of_line = size - np.take_along_axis(gain, best[:, None], axis=1)[:, 0], size - of_line
        floor = size * np.finfo(np.float64).eps * count
        earned = left_of_line > np.maximum(left, floor) * count ** (_PRICE / np.maximum(count, 1))
    return np.where(earned & (best > 0), best + 1, 0)


def _behind(values: Floats) -> Floats:
    """Sum (d, n) of the values behind each point, itself left out."""
    return np.asarray(np.cumsum(values[:, ::-1], axis=1)[:, ::-1] - values)
