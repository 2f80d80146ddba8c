"""How late force follows EMG in a recording: the muscle's own delay, a sensor's filter, or two clocks that differ."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats
from emg2vsa.signals.pairing import Clock

STEP_S = 0.01
"EMG is rectified and averaged over steps of this length."
DRIFT_STEPS = 10
"... after the mean of so many steps is subtracted, a rough high-pass."
SMOOTH_STEPS = 5
MOST_S = 2.0
"A larger lag is not looked for: presses repeat every few seconds."
LEVELS = 24
"Force is told apart in so many levels of ln F."
FINE_STEPS = 3
"The scatter is a parabola in the lag so many steps around its least."
FEIGNED_S = 0.005
"Sudden presses (0.7 s) and stairs show 2 to 3 ms that are not there."
LOWEST = 0.25
"Force below this share of the window's lower force counts as no force."


@dataclass(frozen=True)
class Lag:
    """lag_s : force follows EMG so late; negative where force leads. se_s : its standard error, from so many pieces of
    the record. NaN: not known."""

    lag_s: float
    se_s: float
    pieces: int = 0

    @property
    def certain(self) -> bool:
        """Whether it differs from zero by more than its 99.7 % interval and what the way of pressing can feign."""
        return bool(abs(self.lag_s) > FEIGNED_S + special.stdtrit(max(self.pieces - 1, 1), 0.9985) * self.se_s)


UNKNOWN = Lag(float("nan"), float("nan"))


def estimate_lag(
    channels: tuple[Floats, ...], emg: Clock, force_n: Floats, force: Clock, lower_n: float, stop_s: Floats
) -> Lag:
    """The lag at which the activity is most nearly a function of force, whatever function that is.

    channels : raw EMG (n,) each. force_n : tared force on its own clock. stop_s : (p,) ends of the loading phases; each
    press is one piece of the jackknife. The lag of the best correlation of ln activity with ln F is refined by the
    scatter of ln activity within levels of ln F. UNKNOWN without two presses.
    """
    step = max(1, round(STEP_S * emg.fs_hz))
    activity = _activity(channels, step)
    time_s = emg.time_s(np.arange(activity.size, dtype=np.float64) * step + (step - 1) / 2)
    inside = (time_s >= force.time_s(np.zeros(1))[0]) & (time_s <= force.time_s(np.array([force.n_samples - 1]))[0])
    activity, time_s = activity[inside], time_s[inside]
    most = round(MOST_S * emg.fs_hz / step)
    if stop_s.size < 2 or activity.size < 4 * most or not np.any(activity > 0):
        return UNKNOWN
    y = np.log(np.maximum(activity, 1e-3 * activity.mean()))
    position = np.clip(force.index(time_s), 0, force_n.size - 1)
    left = np.minimum(position.astype(np.int64), force_n.size - 2)
    share = position - left
    u = np.log(np.maximum((1 - share) * force_n[left] + share * force_n[left + 1], LOWEST * lower_n))
    coarse = _best_correlation(y, u, most)
    for _ in range(3):
        scatter, begin = _scatter(y, u, coarse)
        least = int(np.argmin(scatter.sum(axis=1))) - FINE_STEPS
        if abs(least) <= 1:
            break
        coarse += least
    cuts = np.searchsorted(time_s, (stop_s[1:] + stop_s[:-1]) / 2) - begin
    inner = cuts[(cuts > 0) & (cuts < scatter.shape[1])]
    pieces = np.add.reduceat(scatter, np.unique(np.append(0, inner)), axis=1)
    total = pieces.sum(axis=1, keepdims=True)
    lag, *without = coarse + _vertices(np.hstack((total, total - pieces)))
    n = len(without)
    se = np.sqrt((n - 1) / n * np.sum((without - np.mean(without)) ** 2)) if n > 2 else np.nan
    return Lag(float(lag * step / emg.fs_hz), float(se * step / emg.fs_hz), n)


def _activity(channels: tuple[Floats, ...], step: int) -> Floats:
    """Sum of the rectified channels in steps (k,), smoothed over ``SMOOTH_STEPS``."""
    width = step * DRIFT_STEPS
    n = channels[0].size // width * width
    total = np.zeros(n // step)
    for samples in channels:
        blocks = samples[:n].reshape(-1, width)
        rough = np.abs(blocks - blocks.mean(axis=1, keepdims=True))
        total += rough.reshape(-1, step).mean(axis=1)
    return np.asarray(np.convolve(total, np.full(SMOOTH_STEPS, 1 / SMOOTH_STEPS), mode="same"))


def _best_correlation(y: Floats, u: Floats, most: int) -> int:
    """Steps by which u is late, where the correlation of the two is largest."""
    size = 1 << int(y.size + most).bit_length()
    a, b = np.fft.rfft(y - y.mean(), size), np.fft.rfft(u - u.mean(), size)
    across = np.fft.irfft(b * a.conj(), size)
    lags = np.arange(-most, most + 1)
    return int(lags[np.argmax(across[lags])])


def _scatter(y: Floats, u: Floats, coarse: int) -> tuple[Floats, int]:
    """Squared residuals (lags, k) of y about its mean in each level of u, at lags of whole steps around ``coarse``;
    and the step at which they begin."""
    lags = coarse + np.arange(-FINE_STEPS, FINE_STEPS + 1)
    level = ((u - u.min()) * (LEVELS / max(float(np.ptp(u)), 1e-12))).astype(np.int64)
    begin, end = max(0, -int(lags[0])), y.size - max(0, int(lags[-1]))
    own_y = y[begin:end]
    rows = []
    for lag in lags.tolist():
        own = level[begin + lag : end + lag]
        mean = np.bincount(own, own_y) / np.maximum(np.bincount(own), 1)
        rows.append((own_y - mean[own]) ** 2)
    return np.array(rows), begin


def _vertices(scatter: Floats) -> Floats:
    """Where the parabolas through the columns (lags, p) are least, in steps from the middle; 0 where they are not."""
    steps = np.arange(-FINE_STEPS, FINE_STEPS + 1)[:, None]
    bow = steps**2 - np.mean(steps**2)
    square = np.sum(bow * scatter, axis=0) / np.sum(bow * bow)
    linear = np.sum(steps * scatter, axis=0) / np.sum(steps * steps)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(square > 0, np.clip(-linear / (2 * square), -FINE_STEPS, FINE_STEPS), 0.0))
