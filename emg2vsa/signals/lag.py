"""How late force follows EMG in a recording: the muscle's own delay, a sensor's filter, or two clocks that differ."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import signal, special

from emg2vsa.arrays import Floats, Ints, median, slices, sums_of
from emg2vsa.signals.bias import muscle_error_s
from emg2vsa.signals.pairing import Clock

STEP_S = 0.01
"EMG is rectified and averaged over steps of this length."
DRIFT_STEPS = 10
"... after the running mean of so many steps is subtracted: slow wander of the electrode leaves 0.2 % of itself."
ABOVE_MOVEMENT_HZ = 80.0
"Where an electrode moves, activity is taken from above this frequency."
FORGOTTEN = 20.0
"Periods of it after which nothing of a sample is left in the filter."
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
TURN = 0.3
"Force turns where ln F goes back by so much."
LEAST_N = 0.05
"Forces below say nothing of the curve of a recording, ..."
CURVE_SIZE = 10
"... nor do presses with no more samples; ..."
CURVE_CLEAR = 3.0
"... and it is other than the logarithm where the presses together show it by so many standard errors."
APART_S = 0.015
"Rise and release follow one curve where the lag is the same, within this, whether they are told apart or not."
LEAST_EXPLAINED = 0.3
"Force must explain so much of the variance of ln activity."
PRESS_SD_S = 0.003
"One press tells the lag no better than this."
ALONE_S = 0.1
"A lag that one press alone tells counts above this."
DIFFERS_S = 0.03
"Presses whose lags scatter by more, beyond their noise, do not share one, ..."
LARGEST_S = 0.1
"A press that force and EMG are further apart in is not used: clocks part, or a radio lost samples that nobody told."
DIFFERS_CHANCE = 0.01
"... where noise makes them scatter so with this probability."
HALF_STEPS = 3
"The noise of a press's lag is told by two halves of it, which alternate every so many steps."
FAR_S = 0.07
"Noise leaves half the presses within this of the median; the halves tell nothing of a lag so far from the common one."
SMOOTHED = 7.0
"Variance of their sum over that of their difference, for halves of noise: steps are smoothed (measured, white EMG)."
TREND = 5.0
"Clocks drift where the slope of lag against time is so many standard errors, ..."
TREND_S = 0.02
"... and the lag changes by more than this from the first press to the last."


@dataclass(frozen=True)
class Lag:
    """lag_s : force follows EMG so late; negative where force leads. se_s : its standard error, from so many pieces of
    the record. feigned_s : what the way of pressing, and activity that differs on release, can add. drift : seconds
    by which the lag grows each second, about_drift_s : standard deviation of the lags of the presses about that line.
    between_s : that of the lags beyond their noise; 0 where it is not clear. NaN: not known."""

    lag_s: float
    se_s: float
    pieces: int = 0
    feigned_s: float = FEIGNED_S
    drift: float = 0.0
    about_drift_s: float = 0.0
    between_s: float = 0.0

    @property
    def error_s(self) -> float:
        """Standard error, s, with what all presses share, which ``se_s``, by how presses differ, cannot show: what is
        feigned, and that a muscle has no single lag."""
        return float(np.hypot(np.hypot(np.nan_to_num(self.se_s), self.feigned_s), muscle_error_s(self.lag_s)))

    @property
    def certain(self) -> bool:
        """Whether it differs from zero by more than its 99.7 % interval and what can feign a lag."""
        if self.pieces == 1:
            return abs(self.lag_s) > ALONE_S
        return bool(abs(self.lag_s) > self.feigned_s + special.stdtrit(max(self.pieces - 1, 2), 0.9985) * self.se_s)

    def left_s(self, moved_s: float, stop_s: Floats) -> Floats:
        """(p,) s by which force follows EMG in each press where ``moved_s`` was taken out; 0 where it is not certain.

        stop_s : (p,) ends of the loading phases, s.
        """
        if self.drift:
            return np.asarray(self.lag_s - moved_s + self.drift * (stop_s - stop_s.mean()))
        return np.full(stop_s.size, self.lag_s if self.certain and not moved_s else 0.0)

    @property
    def differs(self) -> str:
        """What is to be said of presses, or recordings, that do not share one lag; empty if they do."""
        if self.drift:
            return f"the lag of force drifts by {1e3 * self.drift:.1f} ms a second; do the clocks differ?"
        if self.between_s > DIFFERS_S:
            return f"the lag of force differs by {1e3 * self.between_s:.0f} ms (standard deviation)"
        return ""


UNKNOWN = Lag(float("nan"), float("nan"))


def _log_force(force_n: Floats, force: Clock, time_s: Floats, least_n: float) -> Floats:
    """ln of the force (n,), N, interpolated to times (t,), s; below ``least_n`` that of ``least_n``."""
    position = np.clip(force.index(time_s), 0, force_n.size - 1)
    left = np.minimum(position.astype(np.int64), force_n.size - 2)
    share = position - left
    return np.asarray(np.log(np.maximum((1 - share) * force_n[left] + share * force_n[left + 1], least_n)))


def estimate_lag(
    channels: tuple[Floats, ...],
    emg: Clock,
    force_n: Floats,
    force: Clock,
    lower_n: float,
    stop_s: Floats,
    moved: Sequence[Ints] = (),
    unheard_s: Floats | None = None,
) -> Lag:
    """The lag at which the activity is most nearly a function of force, whatever function that is.

    channels : raw EMG (n,) each. force_n : tared force on its own clock. stop_s : (p,) ends of the loading phases; each
    press is one piece of the jackknife. The lag of the best correlation of ln activity with ln F is refined by the
    scatter of ln activity within levels of ln F. Muscles are quieter on release than at the same force before it, which
    looks like a lag; where it matters that rise and release are told apart, they are. One press has no standard error,
    two have half their difference. moved : spans (k, 2) of samples of each channel in which it moves (``movement``).
    unheard_s : (k, 2) from when to when nothing has a say: gaps, and presses that are rejected.
    UNKNOWN without a press, and where force explains too little of the activity.
    The standard error is the jackknife's (Tukey 1958).
    What is done about a lag: decision 24.
    """
    step = max(1, round(STEP_S * emg.fs_hz))
    activity = _activity(channels, step, emg.fs_hz, moved)
    time_s = emg.time_s(np.arange(activity.size, dtype=np.float64) * step + (step - 1) / 2)
    inside = (time_s >= force.time_s(np.zeros(1))[0]) & (time_s <= force.time_s(np.array([force.n_samples - 1]))[0])
    activity, time_s = activity[inside], time_s[inside]
    most = round(MOST_S * emg.fs_hz / step)
    if stop_s.size < 1 or activity.size < 3 * most or not np.any(activity > 0):
        return UNKNOWN
    y, heard = np.log(np.maximum(activity, 1e-3 * activity.mean())), np.ones(activity.size)
    for begin_s, end_s in [] if unheard_s is None else unheard_s.tolist():
        heard[np.searchsorted(time_s, begin_s) : np.searchsorted(time_s, end_s)] = 0.0
    if not heard.any():
        return UNKNOWN
    y[heard == 0] = y[heard > 0].mean()
    u = _log_force(force_n, force, time_s, LOWEST * lower_n)
    coarse = _best_correlation(y, u, most)
    level = ((u - u.min()) * (LEVELS / max(float(np.ptp(u)), 1e-12))).astype(np.int64)
    cuts = np.searchsorted(time_s, (stop_s[1:] + stop_s[:-1]) / 2)
    second_s = step / emg.fs_hz
    found = _refined(y, level, heard, coarse, cuts)
    together, without = found.lag, found.without
    if not found.explained(y) > LEAST_EXPLAINED:
        return UNKNOWN
    apart = _refined(y, np.where(_rising(u), level, level + LEVELS + 1), heard, coarse, cuts)
    n = without.size
    # rise and release together tell best by how much presses differ, even where both are off by the same
    differing_s = _beyond_noise((n * together - (n - 1) * without) * second_s, found.pulls())
    difference_s = abs(together - apart.lag) * second_s
    if difference_s <= APART_S:
        lag, feigned_s = together, FEIGNED_S + difference_s
    else:
        lag, without, feigned_s = apart.lag, apart.without, FEIGNED_S + difference_s / 2
    lag_s, of_press_s = lag * second_s, (n * lag - (n - 1) * without) * second_s
    if n < 2:
        return Lag(lag_s, float("nan"), 1, feigned_s)
    se_s = float(np.std(of_press_s, ddof=1)) / n**0.5
    if n == 2:
        se_s = max(se_s, PRESS_SD_S / n**0.5)
    drift, about_s = _drift(of_press_s, stop_s) if n == stop_s.size else (0.0, 0.0)
    return Lag(lag_s, se_s, n, feigned_s, drift, about_s, differing_s)


def curve_of(x: Floats, level: Floats, offsets: Ints, at: Sequence[Floats]) -> list[Floats]:
    """The curve of the level (N,) against ln F, x (N,), that the presses of a recording share, at other ln F (k,) each.

    A line in ln F and in F: what a lag does to b depends on which of the two it is. It is ln F alone where the presses
    do not clearly show another, and where the other would fall.
    """
    known = (level > 0) & (x > np.log(LEAST_N))
    found = []
    for first, last in itertools.pairwise(offsets.tolist()):
        own, v = (each[first:last][known[first:last]] for each in (x, level))
        if own.size > CURVE_SIZE:
            columns = np.stack([np.ones_like(own), own, np.exp(own)], axis=-1) / v[:, None]
            found.append(np.linalg.lstsq(columns, np.ones_like(own), rcond=None)[0] / v.mean())
    n = len(found)
    curves = np.array(found).reshape(n, 3)
    of_log, of_force = 1.0, 0.0
    if n > 2:
        mean, se = curves.mean(axis=0), curves.std(axis=0, ddof=1) / n**0.5
        ends_n = np.exp([x[known].min(), x[known].max()])
        if abs(mean[2]) > CURVE_CLEAR * se[2] and np.all(mean[1] + mean[2] * ends_n > 0):
            of_log, of_force = float(mean[1]), float(mean[2])
    return [of_log * own + of_force * np.exp(own) for own in at]


def _beyond_noise(of_press_s: Floats, pulls: Floats) -> float:
    """Standard deviation of the lags (p,) of presses beyond their noise, which the ``pulls`` (p, 2) of the halves of
    each on the common lag tell; 0 where it is not clear, or of fewer than three."""
    n = of_press_s.size
    if n < 3:
        return 0.0
    all_of, noise = float(np.var(pulls.sum(axis=1), ddof=1)), SMOOTHED * float(np.mean(np.diff(pulls) ** 2))
    scatter_s = float(np.std(of_press_s, ddof=1))
    if median(np.abs(of_press_s - median(of_press_s))) > FAR_S:
        return scatter_s
    if not all_of > special.fdtri(n - 1, n, 1 - DIFFERS_CHANCE) * noise:
        return 0.0
    return float(scatter_s * (1 - noise / all_of) ** 0.5)


class _Refined(NamedTuple):
    """lag : in steps, ``vertex`` of them from the middle one looked at. without : (p,) lags without each of the pieces
    that begin at ``begins`` (p,). scatter : (lags, k) from step ``begin`` on; pieces : (lags, p) its sums."""

    lag: float
    without: Floats
    vertex: float
    scatter: Floats
    pieces: Floats
    begins: Ints
    begin: int

    def pulls(self) -> Floats:
        """Slopes of the scatter at the lag (p, 2) that the halves of each piece have."""
        odd = np.arange(self.scatter.shape[1]) // HALF_STEPS % 2 > 0
        second = np.add.reduceat(np.where(odd, self.scatter, 0.0), self.begins, axis=1)
        linear, square = _parabolas(np.stack((self.pieces - second, second), axis=-1))
        return linear + 2 * square * self.vertex

    def explained(self, y: Floats) -> float:
        """Share of the variance of y (n,) that the levels explain."""
        k = self.scatter.shape[1]
        varying = float(np.var(y[self.begin : self.begin + k])) * k
        return 1 - float(self.pieces.sum(axis=1).min()) / varying if varying else 0.0


def _refined(y: Floats, level: Ints, heard: Floats, coarse: int, cuts: Ints) -> _Refined:
    """The lag at which y (n,) scatters least within the levels (n,); the cuts (p,) part the pieces."""
    for _ in range(4):
        scatter, begin = _scatter(y, level, heard, coarse)
        least = int(np.argmin(scatter.sum(axis=1))) - FINE_STEPS
        if abs(least) <= 1:
            break
        coarse += least
    inner = cuts - begin
    inner = inner[(inner > 0) & (inner < scatter.shape[1])]
    begins = np.unique(np.append(0, inner))
    pieces = np.add.reduceat(scatter, begins, axis=1)
    total = pieces.sum(axis=1, keepdims=True)
    lags = _vertices(np.hstack((total, total - pieces)))
    vertex = float(lags[0])
    return _Refined(coarse + vertex, coarse + lags[1:], vertex, scatter, pieces, begins, begin)


def _rising(u: Floats) -> NDArray[np.bool_]:
    """Where u (k,) goes on to its next peak; a rest or a hold belongs half to what is before, half to what follows."""
    rising = np.empty(u.size, dtype=np.bool_)
    changes = np.ones(u.size, dtype=np.bool_)  # within a run of one value nothing happens
    changes[1:-1] = (u[1:-1] != u[:-2]) | (u[1:-1] != u[2:])
    up, extreme, first, last, begin = True, float(u[0]), 0, 0, 0
    least, most = TURN / 100, TURN
    for k, value in zip(np.flatnonzero(changes).tolist(), u[changes].tolist(), strict=True):
        beyond = value - extreme if up else extreme - value
        if beyond > least:
            extreme, first, last = value, k, k
        elif beyond > -least:
            last = k
        elif beyond < -most:
            turn = (first + last) // 2
            rising[begin:turn] = up
            up, extreme, first, last, begin = not up, value, k, k, turn
    rising[begin:] = up
    return rising


def _drift(lag_s: Floats, time_s: Floats) -> tuple[float, float]:
    """Slope of the lags (p,) of the presses against their times (p,), and their standard deviation about it; 0, 0 where
    it is not clear."""
    if lag_s.size < 5:
        return 0.0, 0.0
    lever = time_s - time_s.mean()
    slope = float(lever @ lag_s / (lever @ lever))
    left = lag_s - lag_s.mean() - slope * lever
    about_s = float(np.sqrt(left @ left / (lag_s.size - 2)))
    clear = abs(slope) > TREND * about_s / np.sqrt(lever @ lever) and abs(slope) * np.ptp(time_s) > TREND_S
    return (slope, about_s) if clear else (0.0, 0.0)


def _activity(channels: tuple[Floats, ...], step: int, fs_hz: float, moved: Sequence[Ints]) -> Floats:
    """Sum of the rectified channels in steps (k,), smoothed over ``SMOOTH_STEPS``."""
    half = step * DRIFT_STEPS // 2
    total = np.zeros(channels[0].size // step)
    for number, samples in enumerate(channels):
        steps, centre = np.empty(total.size), float(samples.mean())
        for part in slices(total.size, step):
            rough = _rectified(samples, part.start * step, part.stop * step, half, centre)
            steps[part] = sums_of(rough.reshape(-1, step)) / step
        if moved and len(moved[number]):
            steps = _without_movement(steps, samples, moved[number], step, fs_hz)
        total += steps
    return np.asarray(np.convolve(total, np.full(SMOOTH_STEPS, 1 / SMOOTH_STEPS), mode="same"))


def _rectified(samples: Floats, begin: int, end: int, half: int, centre: float) -> Floats:
    """Samples [begin, end) of (n,) less their running mean over ``half`` to either side, rectified; ``centre`` : about
    their mean, which costs digits."""
    low, high = max(begin - half, 0), min(end + half, samples.size)
    around = samples[low:high] - centre
    sums = np.zeros(around.size + 1)
    np.cumsum(around, out=sums[1:])
    # where both sides are whole, else one by one
    first = min(max(begin, half), end)
    last = max(min(end, samples.size - half), first)
    means = np.empty(end - begin)
    inner = sums[first + half + 1 - low : last + half + 1 - low] - sums[first - half - low : last - half - low]
    np.divide(inner, 2 * half + 1, out=means[first - begin : last - begin])
    for edge in (np.arange(begin, first), np.arange(last, end)):
        left, right = np.maximum(edge - half, 0), np.minimum(edge + half + 1, samples.size)
        means[edge - begin] = (sums[right - low] - sums[left - low]) / (right - left)
    return np.abs(np.subtract(around[begin - low : end - low], means, out=means), out=means)


def _without_movement(steps: Floats, samples: Floats, spans: Ints, step: int, fs_hz: float) -> Floats:
    """Steps (k,) of samples (n,); those that the spans touch are taken from what is faster than movement, at the usual
    ratio."""
    quick_hz = min(ABOVE_MOVEMENT_HZ, 0.25 * fs_hz)
    sections = signal.butter(4, quick_hz, "highpass", fs=fs_hz, output="sos")
    samples, quick = samples[: steps.size * step], np.empty(steps.size)
    reach = round(FORGOTTEN / quick_hz * fs_hz)
    for part in slices(steps.size, step):
        begin, end = part.start * step, part.stop * step
        low, high = max(begin - reach, 0), min(end + reach, samples.size)
        filtered = signal.sosfiltfilt(sections, samples[low:high])[begin - low : end - low]
        np.abs(filtered).reshape(-1, step).mean(axis=1, out=quick[part])
    gone = np.zeros(steps.size, dtype=np.bool_)
    for first, last in spans.tolist():
        gone[max(first // step - DRIFT_STEPS // 2, 0) : -(-last // step) + DRIFT_STEPS // 2] = True
    usual = float(steps[~gone].sum() / max(float(quick[~gone].sum()), 1e-300))
    return np.where(gone, usual * quick, steps)


def _best_correlation(y: Floats, u: Floats, most: int) -> int:
    """Steps by which u is late, where the correlation of the two is largest."""
    size = 1 << int(y.size + most).bit_length()
    a, b = np.fft.rfft(y - y.mean(), size), np.fft.rfft(u - u.mean(), size)
    across = np.fft.irfft(b * a.conj(), size)
    lags = np.arange(-most, most + 1)
    return int(lags[np.argmax(across[lags])])


def _scatter(y: Floats, level: Ints, heard: Floats, coarse: int) -> tuple[Floats, int]:
    """Squared residuals (lags, k) of y about its mean in each level, at lags of whole steps around ``coarse``; and the
    step at which they begin."""
    lags = coarse + np.arange(-FINE_STEPS, FINE_STEPS + 1)
    begin, end = max(0, -int(lags[0])), y.size - max(0, int(lags[-1]))
    own_y, own_heard = y[begin:end], heard[begin:end]
    heard_y, rows = own_heard * own_y, np.empty((lags.size, end - begin))
    weights = None if own_heard.all() else own_heard
    for row, lag in zip(rows, lags.tolist(), strict=True):
        own = level[begin + lag : end + lag]
        mean = np.bincount(own, heard_y) / np.maximum(np.bincount(own, weights), 1)
        np.square(np.subtract(own_y, mean[own], out=row), out=row)
        if weights is not None:
            row *= weights
    return rows, begin


_STEPS = np.arange(-FINE_STEPS, FINE_STEPS + 1.0)
_BOW = _STEPS**2 - np.mean(_STEPS**2)


def _parabolas(scatter: Floats) -> tuple[Floats, Floats]:
    """Linear and square coefficients (...) of the parabolas through the columns (lags, ...), from the middle on."""
    linear, square = (
        np.dot(of[None], scatter.reshape(of.size, -1)).reshape(scatter.shape[1:]) / np.sum(of**2)
        for of in (_STEPS, _BOW)
    )
    return linear, square


def _vertices(scatter: Floats) -> Floats:
    """Where the parabolas through the columns (lags, p) are least, in steps from the middle; 0 where they are not."""
    linear, square = _parabolas(scatter)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(square > 0, np.clip(-linear / (2 * square), -FINE_STEPS, FINE_STEPS), 0.0))
