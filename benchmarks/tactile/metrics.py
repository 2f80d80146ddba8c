"""How wrong a flow is, and which methods nothing beats in time and in error at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray


def endpoint_error_px(flow: NDArray[Any], truth: NDArray[Any]) -> NDArray[np.float64]:
    """(...) length of the difference of two flows (..., 2), px."""
    difference = np.asarray(flow, dtype=np.float64) - truth
    return np.asarray(np.hypot(difference[..., 0], difference[..., 1]))


def angular_error_deg(flow: NDArray[Any], truth: NDArray[Any]) -> NDArray[np.float64]:
    """(...) angle between (u, v, 1) and its truth, degrees: Barron, Fleet and Beauchemin (IJCV 1994), section 3.2."""
    a, b = (np.asarray(field, dtype=np.float64) for field in (flow, truth))
    # the arc tangent stays exact where the arc cosine of nearly 1 loses half the digits
    cross = np.stack([a[..., 1] - b[..., 1], b[..., 0] - a[..., 0], a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]])
    dot = (a * b).sum(axis=-1) + 1
    return np.asarray(np.degrees(np.arctan2(np.sqrt((cross**2).sum(axis=0)), dot)))


def percent_error(found: NDArray[Any] | float, truth: NDArray[Any] | float) -> NDArray[np.float64]:
    """100 (found / truth - 1)."""
    return np.asarray(100.0 * (np.asarray(found, dtype=np.float64) / truth - 1.0))


def sample_sd(values: NDArray[Any]) -> float:
    """Standard deviation with n - 1; 0 for a single value, which spreads over nothing."""
    return float(np.std(values, ddof=1)) if np.size(values) > 1 else 0.0


def root_mean_square(values: NDArray[Any]) -> float:
    """Bias and spread in one number."""
    return float(np.sqrt(np.mean(np.square(values))))


def worst(errors: Sequence[float]) -> float:
    """Largest size; infinite where a number is missing, so that what fails is never the best."""
    sizes = np.abs(errors)
    return float("inf") if np.isnan(sizes).any() else float(sizes.max())


def median_sd(errors: Sequence[float]) -> tuple[float, float]:
    """Median and standard deviation of the numbers that are there; NaN where none is."""
    known = np.array([error for error in errors if np.isfinite(error)])
    return (float(np.median(known)), sample_sd(known)) if known.size else (float("nan"), float("nan"))


def pareto_front(time: Sequence[float], error: Sequence[float]) -> list[int]:
    """Indices of the points no other point beats in both, fastest first; of equal points the first counts."""
    front: list[int] = []
    for i in sorted(range(len(time)), key=lambda i: (time[i], error[i])):
        if not front or error[i] < error[front[-1]]:
            front.append(i)
    return front
