"""The unit that activity is shown in: volts are stored, microvolts are read."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True)
class ActivityScale:
    """Multiply stored activity by ``factor`` to show it in ``unit`` ("" for a normalised activity)."""

    unit: str
    factor: float

    def label(self, quantity: str) -> str:
        """Axis label or table head: the quantity with its unit in brackets."""
        return f"{quantity} ({self.unit})" if self.unit else quantity


def activity_scale(activity_unit: str, values: ArrayLike) -> ActivityScale:
    """The unit that brings the largest of ``values`` to one or more; volts stay volts from 1 V on."""
    if activity_unit != "V":
        return ActivityScale("", 1.0)
    finite = np.abs(np.asarray(values, dtype=np.float64))
    largest = float(np.max(finite, initial=0.0, where=np.isfinite(finite)))
    if largest >= 1:
        return ActivityScale("V", 1.0)
    return ActivityScale("mV", 1e3) if largest >= 1e-3 else ActivityScale("µV", 1e6)
