"""Force over time: rest, loading at a constant rate with rounded ends, unloading; its frames and its log."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.worlds.tactile.draws import Draws
from emg2vsa.worlds.tactile.scatter import Drawn
from emg2vsa.worlds.tactile.settings import TimelineSettings

FIRST_FRAME_ROW = 4.5
"The first frame is exposed between the fifth and the sixth row of the log, so rows and frames never tie."

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Timeline:
    """Frames and force of one press.

    frame_time_s, frame_force_n : (T,) exposure and true force there.
    peak_time_s : end of loading.
    log_time_s, log_force_n, log_frame_index : (n,) rows of the force log; the index is that of the last frame saved,
        -1 before the first.
    """

    frame_time_s: FloatArray
    frame_force_n: FloatArray
    peak_time_s: float
    log_time_s: FloatArray
    log_force_n: FloatArray
    log_frame_index: NDArray[np.int64]


def make_timeline(
    settings: TimelineSettings, frame_rate_hz: float, draws: Draws, drawn: Drawn, jitter_sd_s: float
) -> Timeline:
    """Timeline of the press of ``draws``: its speed, its start against the frame clock, its noise and its delays."""
    rng = draws.of("timing")
    rate = (
        (settings.peak_n - settings.start_n)
        / settings.loading_s
        * (1 + rng.uniform(-settings.speed_share, settings.speed_share))
    )
    first_frame_s = FIRST_FRAME_ROW / settings.log_rate_hz
    touch_s = first_frame_s + (settings.rest_frames - 1 + rng.uniform()) / frame_rate_hz
    peak_s = touch_s + settings.peak_n / rate + settings.rounding_s
    n_frames = math.floor((peak_s + settings.unloading_s - first_frame_s) * frame_rate_hz) + 2
    frame_s = first_frame_s + np.arange(n_frames) / frame_rate_hz
    log_s = np.arange(math.ceil((frame_s[-1] + 1 / frame_rate_hz) * settings.log_rate_hz)) / settings.log_rate_hz
    noise_n = settings.force_noise_n * draws.of("force").standard_normal(log_s.size)
    jitter_s = jitter_sd_s * draws.of("jitter").standard_normal(n_frames)
    counted_s = np.maximum.accumulate(frame_s + drawn.latency_s + jitter_s)
    return Timeline(
        frame_time_s=frame_s,
        frame_force_n=_force(frame_s, touch_s, peak_s, rate, settings),
        peak_time_s=peak_s,
        log_time_s=log_s,
        log_force_n=_force(log_s, touch_s, peak_s, rate, settings) + drawn.force_zero_n + noise_n,
        log_frame_index=np.searchsorted(counted_s, log_s).astype(np.int64) - 1,
    )


def _force(time_s: FloatArray, touch_s: float, peak_s: float, rate: float, settings: TimelineSettings) -> FloatArray:
    """True force, N: the rate rises linearly within ``rounding_s``, stays, and falls the same way to 0 at the peak."""
    rounding = settings.rounding_s
    since = np.clip(time_s - touch_s, 0.0, peak_s - touch_s)
    left = (peak_s - touch_s) - since
    rise = np.minimum(since, rounding) ** 2 / (2 * rounding) + np.maximum(since - rounding, 0.0)
    loading = rate * (rise - np.maximum(rounding - left, 0.0) ** 2 / (2 * rounding))
    unloading = (1 + np.cos(np.pi * np.clip((time_s - peak_s) / settings.unloading_s, 0.0, 1.0))) / 2
    return np.asarray(loading * unloading)
