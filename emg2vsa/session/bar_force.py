"""The force that the participant sees: filtered, from its zero, with the direction in which it goes; and its mean."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.session.views import Direction

SLOPE_S = 0.1
"The direction is the slope over this time."
MOVING_N_PER_S = 0.3
"A slower change is steady: the last direction stays."
LEAST_S = 0.1
"A direction stays so long, for a colour that flickers tells nothing."
RESTING_N = 0.5
"Below this force there is no direction."
ZERO_S = 0.5
"The zero of force is the mean over this time."
STEADY_N = 0.2
"The force must not change by more while its zero is taken."


class BarForce:
    """Low-pass of the first order, whose step needs 1 / (2 pi cutoff) seconds, and direction with hysteresis.

    ``force_n`` is the newest filtered force less ``zero_n``; ``peak_n`` the largest since ``restart_peak``.
    """

    def __init__(self, cutoff_hz: float) -> None:
        self._cutoff_hz = cutoff_hz
        self.zero_n = 0.0
        self.peak_n = 0.0
        self.direction: Direction = "none"
        self._raw_n: float | None = None
        self._changed_s = -math.inf
        self._past: deque[tuple[float, float]] = deque()

    @property
    def force_n(self) -> float:
        """The newest, N; 0 before any sample."""
        return 0.0 if self._raw_n is None else self._raw_n - self.zero_n

    def restart_peak(self) -> None:
        """The next press begins."""
        self.peak_n = self.force_n

    def take(self, samples: Floats, fs_hz: float, newest_s: float) -> None:
        """Samples (n,) in newtons, the last one at ``newest_s``; one that is no number keeps the force as it is."""
        share = 1.0 - math.exp(-2 * math.pi * self._cutoff_hz / fs_hz)
        level = self._raw_n
        for sample in samples[np.isfinite(samples)].tolist():
            level = sample if level is None else level + share * (sample - level)
            self.peak_n = max(self.peak_n, level - self.zero_n)
        if level is None:
            return
        self._raw_n = level
        self._turn_direction(newest_s)

    def _turn_direction(self, now_s: float) -> None:
        self._past.append((now_s, self.force_n))
        while len(self._past) > 1 and self._past[1][0] <= now_s - SLOPE_S:
            self._past.popleft()
        then_s, then_n = self._past[0]
        slope = (self.force_n - then_n) / (now_s - then_s) if now_s - then_s >= SLOPE_S / 2 else 0.0
        wanted = self.direction
        if self.force_n < RESTING_N:
            wanted = "none"
        elif slope > MOVING_N_PER_S:
            wanted = "rising"
        elif slope < -MOVING_N_PER_S:
            wanted = "falling"
        elif wanted == "none":
            wanted = "steady"
        if wanted != self.direction and now_s - self._changed_s >= LEAST_S:
            self.direction, self._changed_s = wanted, now_s


class RecentForce:
    """The force of the last half second, N, as it came."""

    def __init__(self) -> None:
        self._pieces: deque[tuple[float, Floats]] = deque()

    def take(self, samples: Floats, now_s: float) -> None:
        """Samples (n,), N, that have come at ``now_s``, s."""
        self._pieces.append((now_s, samples))
        while self._pieces[0][0] < now_s - ZERO_S:
            self._pieces.popleft()

    @property
    def mean_n(self) -> float:
        """Mean, N; NaN where nothing came."""
        return float(np.nanmean(self._newton())) if self._pieces else math.nan

    @property
    def steady(self) -> bool | None:
        """Whether nobody touches the specimen; None where nothing came."""
        if not self._pieces:
            return None
        newton = self._newton()
        size = max(1, newton.size // 10)
        means = newton[: newton.size // size * size].reshape(-1, size).mean(axis=1)
        return bool(np.isfinite(means).all()) and float(np.ptp(means)) <= STEADY_N

    def _newton(self) -> Floats:
        return np.concatenate([newton for _, newton in self._pieces])
