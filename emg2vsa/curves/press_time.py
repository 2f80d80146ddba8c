"""How fast a plate presses, and how much of the force relaxes while it holds still."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats

_STILL = 0.01
"""Share of the travel within which the plate holds its depth."""
_LEAST_S, _LEAST = 1.0, 12


@dataclass(frozen=True)
class PressTime:
    """speed_mm_per_s : of the plate from a tenth to nine tenths of its way. held_s : at its deepest. relaxed : share
    of the force at the start of the hold that is gone at its end; NaN where it does not hold for 1 s."""

    speed_mm_per_s: float
    held_s: float
    relaxed: float


def press_time(depth_mm: Floats, force_n: Floats, time_s: Floats) -> PressTime | None:
    """How fast a plate pressed. (n,) each, mm, N and s, as measured; NaN is left out. None where time does not rise."""
    known = np.isfinite(depth_mm) & np.isfinite(force_n) & np.isfinite(time_s)
    x, y, t = depth_mm[known], force_n[known], time_s[known]
    if x.size < _LEAST or not np.all(np.diff(t) >= 0) or not np.ptp(t) > 0:
        return None
    x, y = (-x, -y) if abs(np.min(x - x[0])) > np.max(x - x[0]) else (x, y)
    travel, deepest = float(np.ptp(x)), float(x.max())
    held = np.flatnonzero(x >= deepest - _STILL * travel)
    first, last = int(held[0]), int(held[-1])
    rising = x[: first + 1]
    way = (rising > x[0] + 0.1 * travel) & (rising < x[0] + 0.9 * travel)
    at, on = t[: first + 1][way], rising[way]
    apart = max(at.size // 10, 1)
    with np.errstate(divide="ignore", invalid="ignore"):  # a median: a rest on the way is not its speed
        speed = (
            float(np.median((on[apart:] - on[:-apart]) / (at[apart:] - at[:-apart]))) if at.size >= _LEAST else np.nan
        )
    pause_s, rest = float(t[last] - t[first]), float(np.median(y[:5]))
    moving_s = 2 * _STILL * travel / speed if speed > 0 else 0.0  # the plate's own way through the band, there and back
    ends = [float(np.median(each)) for each in (y[first : first + 3], y[max(last - 2, first) : last + 1])]
    holds = pause_s - moving_s >= _LEAST_S and held.size >= _LEAST and ends[0] > rest
    return PressTime(speed, pause_s if holds else 0.0, (ends[0] - ends[1]) / (ends[0] - rest) if holds else np.nan)
