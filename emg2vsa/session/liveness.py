"""What a stream sends just now: half of its samples, or one value; told before a press is lost to it.

That a stream sends nothing at all is told by the time since its last samples (`recorded_stream`), and small errors of
its rate by its clock (`sample_clock`).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats
from emg2vsa.devices.streams import StreamInfo

WINDOW_S = 0.9
"Time over which samples are looked at. A fault that is there from the start is told within 2 s."
TOO_FEW = 0.65
"A stream that sends a smaller share of its samples is told; a radio that loses so many is none."


class _Came(NamedTuple):
    """Samples that came at a time: how many, and the smallest and largest value of each channel, NaN without any."""

    at_s: float
    samples: int
    least: Floats
    most: Floats


class Liveness:
    """Liveness of one stream whose source states ``info``. begun_s : time from which on it is heard."""

    def __init__(self, info: StreamInfo, begun_s: float) -> None:
        self._info, self._begun_s = info, begun_s
        self._came: deque[_Came] = deque()

    def take(self, samples: NDArray[np.float64], now_s: float) -> None:
        """Samples (n, channels) that have come at ``now_s``, s, n >= 1."""
        self._came.append(_Came(now_s, len(samples), np.fmin.reduce(samples), np.fmax.reduce(samples)))
        while self._came[0].at_s < now_s - WINDOW_S:
            self._came.popleft()

    def problems(self, now_s: float) -> Iterator[str]:
        """What is wrong in the last ``WINDOW_S`` before ``now_s``, s, a sentence each with what to do."""
        came = [each for each in self._came if each.at_s >= now_s - WINDOW_S]
        if now_s - self._begun_s < WINDOW_S or not came:
            return
        if (hz := sum(each.samples for each in came) / WINDOW_S) < TOO_FEW * self._info.fs_hz:
            yield (
                f"About {hz:.0f} samples a second come, {self._info.fs_hz:.6g} are stated: check the mode of the "
                "device, and the distance to its radio."
            )
        least, most = np.fmin.reduce([each.least for each in came]), np.fmax.reduce([each.most for each in came])
        for channel, low, high in zip(self._info.channels, least.tolist(), most.tolist(), strict=True):
            if np.isnan(low):
                yield f"{channel} sends no values: check that its sensor is paired, charged and switched on."
            elif low == high:
                yield f"{channel} sends one value only, {low:.3g} {self._info.unit}: check its sensor and its cable."
