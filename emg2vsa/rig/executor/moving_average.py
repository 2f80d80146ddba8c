"""The moving average of the force, and what it truly does to it."""

from __future__ import annotations

import math
from collections import deque


class MovingAverage:
    """Mean of the last ``n`` samples, one at a time; of those there are while there are fewer.

    Parameters
    ----------
    n : samples.
    rate_hz : samples a second.

    The paper (section V) says of five samples at 200 Hz "about 5 Hz, delay 0.5 s"; they are 18 Hz and 10 ms, and 5 Hz
    needs 18 samples. So the filter says itself what it is: `description`.
    """

    def __init__(self, n: int, rate_hz: float) -> None:
        self.n, self.rate_hz = n, rate_hz
        self._samples: deque[float] = deque(maxlen=n)
        self._means: deque[float] = deque(maxlen=n + 1)

    def update(self, value: float) -> float:
        """The mean with this sample."""
        self._samples.append(value)
        # summed anew every time: a running sum would keep every rounding error, and a NaN for ever
        self._means.append(math.fsum(self._samples) / len(self._samples))
        return self._means[-1]

    @property
    def growth_per_s(self) -> float:
        """Of the mean, over the last ``n`` samples; 0 before there are two."""
        steps = len(self._means) - 1
        return (self._means[-1] - self._means[0]) * self.rate_hz / steps if steps > 0 else 0.0

    @property
    def delay_s(self) -> float:
        """Group delay, the same at all frequencies, s."""
        return (self.n - 1) / (2 * self.rate_hz)

    @property
    def cutoff_hz(self) -> float:
        """Frequency at which the amplitude has fallen by 3 dB, Hz; inf for a single sample.

        There |sin(pi n f / rate) / (n sin(pi f / rate))| = 1 / sqrt 2.
        """
        if self.n == 1:
            return math.inf
        low, high = 0.0, 1.0 / self.n  # the amplitude falls from 1 to its first zero, at rate / n
        while high - low > 1e-12:
            middle = (low + high) / 2
            amplitude = math.sin(math.pi * self.n * middle) / (self.n * math.sin(math.pi * middle))
            low, high = (middle, high) if amplitude > math.sqrt(0.5) else (low, middle)
        return low * self.rate_hz

    @property
    def description(self) -> str:
        """Length, cut-off and delay in words."""
        if self.n == 1:
            return "no filter: every sample by itself"
        return (
            f"mean of {self.n} samples at {self.rate_hz:g} Hz: -3 dB at {self.cutoff_hz:.3g} Hz, "
            f"delay {1e3 * self.delay_s:.3g} ms"
        )
