"""How late the frames are against the force: pins begin to move when the force begins to rise.

Both begin slowly, so neither beginning is looked for alone. Early in a contact the motion of the pins is close to a
power of the force, a F(t - lag)^p. Lag, a and p are those that fit best to all frames up to 0.4 N. In finite-element
contacts of any stiffness p is 0.8 to 0.95. As no contact is quite of that law, the lag is wrong by about the time in
which the force rises by 0.04 N, which is in the standard error: finite elements -5 +- 11 ms at 1.3 N/s, the simulator,
whose pins set off faster, -23 +- 8 ms at 2.2 N/s (mean and SD of 32 and 36 presses, with any true lag).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from casr.frames.readings import ForceReadings, noise_n

_Array = NDArray[np.float64]
Points = NDArray[np.float64]

UP_TO = 0.8  # of the force of first contact: frames beyond it are not in the fit
FARTHEST_S = 0.3
POWER, POWER_SD = 0.88, 0.05
PIN_SD_PX = 0.03  # of a centroid
SHAPE = 0.05  # of the motion: what the law leaves
LAW_N = 0.04  # what a contact of another law moves the onset by
SMOOTH_S = 0.025
FEWEST_MOVING = 3
MOVING = 4.0  # standard errors of the motion
ROUNDS = 4
STARTS_S = (-0.1, 0.0, 0.1)
WORST = 9.0  # mean square of the residuals, in their variance
FINEST_S = 5e-4
SURE_S = 0.01  # standard error of a lag that is taken off unasked


@dataclass(frozen=True)
class CameraLag:
    """How much later than they were taken the frames are stamped against the force log.

    lag_s, sd_s : s, and its standard error; None where they are not determined. why : then the reason.
    period_s : of the frames, None where not known. corrected_s : taken off the times of the frames, s.
    """

    lag_s: float | None
    sd_s: float | None
    why: str = ""
    period_s: float | None = None
    corrected_s: float = 0.0

    @property
    def remaining_s(self) -> float | None:
        """What is left of it in the forces of the frames, s."""
        return None if self.lag_s is None else self.lag_s - self.corrected_s

    @property
    def doubtful(self) -> bool:
        """Whether what is left is more than half a frame and twice its error: the forces belong to other frames."""
        left_s = self.remaining_s
        if left_s is None or self.sd_s is None or self.period_s is None:
            return False
        return abs(left_s) > max(2 * self.sd_s, self.period_s / 2)

    @property
    def sure(self) -> bool:
        """Whether what is left is to be taken off: known to 10 ms and more than its error, or doubtful."""
        left_s, sd_s = self.remaining_s, self.sd_s
        return self.doubtful or (left_s is not None and sd_s is not None and sd_s <= SURE_S and abs(left_s) > sd_s)


def camera_lag(
    frames: NDArray[np.intp], pins_px: Points, readings: ForceReadings, *, zero_n: float, start_n: float
) -> CameraLag:
    """Lag of the frames around first contact.

    frames : (m,) indices, the first at rest. pins_px : (m, N, 2) where the same pins are in them, NaN where lost.
    zero_n : what the sensor reads at rest, N. start_n : force of first contact, N.
    """
    taken_s = readings.frame_time_s[frames]
    known = np.isfinite(taken_s)
    taken_s, pins_px = taken_s[known], pins_px[known]
    seen = np.isfinite(pins_px).all(axis=(0, 2)) if len(taken_s) else np.zeros(0, dtype=np.bool_)
    if len(taken_s) < 2 * FEWEST_MOVING or seen.sum() < 7:
        return CameraLag(None, None, "too few frames with a time and pins around first contact")
    period_s = float(np.median(np.diff(taken_s)))
    rise = _Rise(readings, zero_n, taken_s[-1] + FARTHEST_S)
    moved_px = pins_px[:, seen] - pins_px[0, seen]
    found = _fitted(taken_s, moved_px, rise, UP_TO * start_n)
    if isinstance(found, str):
        return CameraLag(None, None, found, period_s)
    lag_s, fit_sd_s, rate = found
    sd_s = float(np.hypot(fit_sd_s, LAW_N / rate)) if rate > 0 else np.inf
    if not sd_s <= period_s:
        why = f"known to {sd_s:.2g} s only (standard error): the force rises by {rate:.2g} N/s at first contact"
        return CameraLag(None, None, why, period_s)
    if abs(lag_s) > FARTHEST_S - 2 * sd_s:
        return CameraLag(None, None, f"beyond {FARTHEST_S:g} s", period_s)
    return CameraLag(lag_s, sd_s, "", period_s)


class _Rise:
    """The force above its zero, each reading the mean of those within 25 ms.

    sd_n : standard deviation of such a mean.
    """

    def __init__(self, readings: ForceReadings, zero_n: float, until_s: float) -> None:
        rows = readings.time_s <= until_s
        time_s, force_n = readings.time_s[rows], readings.force_n[rows] - zero_n
        step_s = float(np.median(np.diff(time_s))) if time_s.size > 1 else 0.0
        n = int(min(max(round(SMOOTH_S / step_s), 1), max(time_s.size, 1))) if step_s > 0 else 1
        # the mean of the times goes with the mean of the forces, so a straight rise stays where it is
        even = np.full(n, 1 / n)
        self._time_s = np.convolve(time_s, even, "valid")
        self._force_n = np.convolve(force_n, even, "valid")
        self.sd_n = noise_n(force_n) / np.sqrt(n) if force_n.size > 2 else 0.0

    def __call__(self, time_s: _Array) -> _Array:
        return np.asarray(np.interp(time_s, self._time_s, self._force_n))


def _fitted(taken_s: _Array, moved_px: Points, rise: _Rise, up_to_n: float) -> tuple[float, float, float] | str:
    """Lag, s, its standard error by the fit, s, and the rate of the force there, N/s; or why there is none."""
    law_of = cache(partial(_law_of, taken_s=taken_s, moved_px=moved_px, rise=rise, up_to_n=up_to_n))
    found = [_fitted_from(start_s, taken_s, rise, up_to_n, law_of) for start_s in STARTS_S]
    fits = [each for each in found if not isinstance(each, str)]
    if not fits:
        return str(found[len(found) // 2])
    good = [fit for fit in fits if fit[0].misfit_of_one(fit[2]) <= WORST]
    if not good:
        return "the motion of the pins does not follow the force"
    # where skin that stuck begins to stretch the motion sets off once more, later
    law, n, lag_s = min(good, key=lambda fit: fit[2])
    times_s = np.linspace(taken_s[0] - lag_s, taken_s[n - 1] - lag_s, 200)
    force_n = rise(times_s)
    rising = force_n > force_n.max() / 4
    rate = float(np.polyfit(times_s[rising], force_n[rising], 1)[0]) if rising.sum() > 2 else 0.0
    return lag_s, law.error_s(lag_s), rate


def _fitted_from(
    lag_s: float, taken_s: _Array, rise: _Rise, up_to_n: float, law_of: Callable[[int], _Law | str]
) -> tuple[_Law, int, float] | str:
    """The law of the first n frames, n, and the lag, or why there is none.

    Which frames are in the fit depends on the lag, so they are chosen again until it stays the same.
    """
    for _ in range(ROUNDS):
        beyond = np.flatnonzero(rise(taken_s - lag_s) > up_to_n)
        if not beyond.size:
            return "the force does not rise within these frames"
        n = max(int(beyond[0]), FEWEST_MOVING)
        found = law_of(n)
        if isinstance(found, str):
            return found
        law = found
        before_s, lag_s = lag_s, law.best_lag_s
        if abs(lag_s - before_s) < FINEST_S:
            break
    return law, n, lag_s


def _law_of(n: int, taken_s: _Array, moved_px: Points, rise: _Rise, up_to_n: float) -> _Law | str:
    """Law of the first n frames, or the reason why there is none."""
    way = moved_px[min(n, len(moved_px) - 1)]
    length_px = float(np.sqrt((way**2).sum()))
    if length_px == 0:
        return "the pins do not move"
    # along the pattern of the later motion noise has no sign, so frames at rest scatter about 0
    along_px = (moved_px[:n] * way).sum(axis=(1, 2)) / length_px
    if int((along_px > MOVING * PIN_SD_PX).sum()) < FEWEST_MOVING:
        return f"the pins move in fewer than {FEWEST_MOVING} frames before {up_to_n:.2g} N"
    noise_px = np.hypot(PIN_SD_PX, rise.sd_n * along_px.max() / up_to_n)
    return _Law(taken_s[:n], along_px, np.hypot(noise_px, SHAPE * along_px), rise)


class _Law:
    """Residuals of a F(t - lag)^p at (n,) times ``taken_s`` from the motion there, in its standard deviations."""

    def __init__(self, taken_s: _Array, moved_px: _Array, sd_px: _Array, rise: _Rise) -> None:
        self._taken_s, self._moved, self._sd_px, self._rise = taken_s, moved_px / sd_px, sd_px, rise
        self._powers = POWER + POWER_SD * np.linspace(-3, 3, 61)

    def _misfit(self, lag_s: NDArray[np.floating[Any]]) -> _Array:
        """(L,) least sum of squared residuals, of all powers, for lags (L,).

        One of the residuals is how far the power is from the one expected.
        """
        force_n = self._rise(self._taken_s - lag_s[:, None])[:, None]
        # noise about zero keeps its sign
        law = np.sign(force_n) * np.abs(force_n) ** self._powers[:, None] / self._sd_px  # (L, 61, n)
        size = (law**2).sum(axis=-1)
        scale = np.divide((law * self._moved).sum(axis=-1), size, out=np.zeros_like(size), where=size > 0)
        left = ((self._moved - scale[..., None] * law) ** 2).sum(axis=-1)
        return np.asarray((left + ((self._powers - POWER) / POWER_SD) ** 2).min(axis=-1))

    def misfit_of_one(self, lag_s: float) -> float:
        """Mean square of the residuals, by the degrees of freedom."""
        return float(self._misfit(np.array([lag_s]))[0]) / max(self._taken_s.size - 2, 1)

    @cached_property
    def best_lag_s(self) -> float:
        """The lag of the least misfit, to half a millisecond."""
        best_s, step_s = 0.0, 0.01
        around: NDArray[np.floating[Any]] = np.arange(-FARTHEST_S, FARTHEST_S + step_s / 2, step_s)
        while step_s >= FINEST_S:
            best_s = float(around[np.argmin(self._misfit(around))])
            step_s /= 5
            around = best_s + step_s * np.arange(-5.0, 6.0)
        return best_s

    def error_s(self, lag_s: float) -> float:
        """Standard error from how fast the misfit rises on either side, whatever the power there."""
        step_s = 0.005
        before, least, after = self._misfit(lag_s + step_s * np.array([-1.0, 0.0, 1.0])).tolist()
        bend = (after + before - 2 * least) / step_s**2
        spread = max(self.misfit_of_one(lag_s), 1.0)
        return float(np.sqrt(2 * spread / bend)) if bend > 0 else float("inf")
