"""Stiffness of a specimen from indenting it with a plate: moving average, then Hooke's law (paper IV.B)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.curves.hooke import HookeFit, fit_hooke
from emg2vsa.errors import SettingError

PAPER_WINDOW = 5
"""Samples of the paper's moving average."""


def fit_plate(trials: Sequence[tuple[Floats, Floats]], window: int = PAPER_WINDOW) -> HookeFit:
    """Fit every trial up to its deepest point, smoothed; d trials of (n,) indentation, mm, and (n,) force, N.

    Both are averaged over ``window`` samples, so that neither lags the other. What comes after the deepest point is
    unloading, where a viscous specimen is softer.

    Raises
    ------
    SettingError : a window below 1.
    """
    if window < 1:
        raise SettingError("window", wanted="1 sample or more", found=str(window), do="The paper takes 5.")
    loaded = [_loading(*trial) for trial in trials]
    smooth = [(_averaged(x, window), _averaged(y, window)) for x, y in loaded]
    longest = max((x.size for x, _ in smooth), default=0)
    padded = np.full((2, len(smooth), longest), np.nan)
    for row, (x, y) in enumerate(smooth):
        padded[0, row, : x.size], padded[1, row, : y.size] = x, y
    return fit_hooke(padded[0], padded[1])


def _loading(indentation_mm: Floats, force_n: Floats) -> tuple[Floats, Floats]:
    known = np.isfinite(indentation_mm) & np.isfinite(force_n)
    x, y = indentation_mm[known], force_n[known]
    end = int(np.argmax(x)) + 1 if x.size else 0
    return x[:end], y[:end]


def _averaged(values: Floats, window: int) -> Floats:
    if values.size < window:
        return np.empty(0)
    return np.convolve(values, np.full(window, 1 / window), mode="valid")
