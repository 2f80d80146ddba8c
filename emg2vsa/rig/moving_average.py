"""The moving average of the force, and what it truly does to it."""

from __future__ import annotations

import math
from collections import deque

from emg2vsa.errors import SettingError


class MovingAverage:
    """Mean of the last ``n`` samples, one at a time; of those there are while there are fewer.

    Parameters
    ----------
    n : samples.
    rate_hz : samples a second.

    Raises
    ------
    SettingError : fewer than one sample, or a rate not above 0.

    The paper (section V) says of five samples at 200 Hz "about 5 Hz, delay 0.5 s"; they are 18 Hz and 10 ms, and 5 Hz
    needs 18 samples. So the filter says itself what it is: `description`.
    """

    def __init__(self, n: int, rate_hz: float) -> None:
        if n < 1 or not 0 < rate_hz < math.inf:
            raise SettingError(
                "moving average",
                wanted="one sample or more and a rate above 0 Hz",
                found=f"{n} samples at {rate_hz:g} Hz",
                do="The paper's is 5 samples at 200 Hz.",
            )
        self.n, self.rate_hz = n, rate_hz
        self._samples: deque[float] = deque(maxlen=n)

    def update(self, value: float) -> float:
        """The mean with this sample."""
        self._samples.append(value)
        # summed anew every time: a running sum would keep every rounding error, and a NaN for ever
        return math.fsum(self._samples) / len(self._samples)

    def reset(self) -> None:
        """Forget all samples."""
        self._samples.clear()

    @property
    def delay_s(self) -> float:
        """Group delay, the same at all frequencies, s."""
        return (self.n - 1) / (2 * self.rate_hz)

    @property
    def cutoff_hz(self) -> float:
        """Frequency at which the amplitude has fallen by 3 dB, Hz; inf for a single sample."""
        return cutoff_hz(self.n, self.rate_hz)

    @property
    def description(self) -> str:
        """Length, cut-off and delay in words."""
        if self.n == 1:
            return "no filter: every sample by itself"
        return (
            f"mean of {self.n} samples at {self.rate_hz:g} Hz: -3 dB at {self.cutoff_hz:.3g} Hz, "
            f"delay {1e3 * self.delay_s:.3g} ms"
        )


def cutoff_hz(n: int, rate_hz: float) -> float:
    """-3 dB frequency of the mean of ``n`` samples, Hz; inf for one.

    There |sin(pi n f / rate) / (n sin(pi f / rate))| = 1 / sqrt 2.
    """
    if n == 1:
        return math.inf
    low, high = 0.0, 1.0 / n  # the amplitude falls from 1 to its first zero, at rate / n
    while high - low > 1e-12:
        middle = (low + high) / 2
        amplitude = math.sin(math.pi * n * middle) / (n * math.sin(math.pi * middle))
        low, high = (middle, high) if amplitude > math.sqrt(0.5) else (low, middle)
    return low * rate_hz


def samples_for(wanted_hz: float, rate_hz: float) -> int:
    """Number of samples whose cut-off is nearest to ``wanted_hz``; at least 2, as one does not filter."""
    if not 0 < wanted_hz < rate_hz / 2:
        raise SettingError(
            "cut-off",
            wanted=f"a frequency above 0 and below half of {rate_hz:g} Hz",
            found=f"{wanted_hz:g} Hz",
            do="Correct one of them.",
        )
    n = 2
    while cutoff_hz(n + 1, rate_hz) >= wanted_hz:
        n += 1
    return min((n, n + 1), key=lambda length: abs(cutoff_hz(length, rate_hz) - wanted_hz))
