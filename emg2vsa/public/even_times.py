"""Rate and start of a column of times in a table, which may be rounded more coarsely than its samples follow."""

from __future__ import annotations

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.errors import DataError, SettingError

_REPEATING = 0.02
"""Fewer steps of another length than the usual are lost or repeated samples, and no rounding."""
_DRIFT = 0.5
"""Of a step: the most that times wander about even spacing. One lost sample makes them wander by a whole step."""
_RATES_DIFFER = 0.01


def rate_and_start(time_s: Floats, fs_hz: float | None) -> tuple[float, float]:
    """Rate (Hz) and start (s) of times (n,) in seconds; ``fs_hz`` goes before the measured rate where it is given.

    Times are judged as a whole: about the straight line through them they may wander by their rounding and half a step.
    DataError: they are not evenly spaced. SettingError: ``fs_hz`` is another rate.
    """
    even = time_s.size > 1 and bool(np.isfinite(time_s).all())
    steps = np.diff(time_s) if even else np.zeros(1)
    rounding_s = _rounding_s(time_s, steps) if even else 0.0
    even = even and bool(np.all(steps >= 0 if rounding_s else steps > 0)) and bool(time_s[-1] > time_s[0])
    if even:
        counts = np.arange(time_s.size) - (time_s.size - 1) / 2
        since_s = time_s - time_s.mean()
        step_s = float(counts @ since_s / (counts @ counts))
        even = bool(np.ptp(since_s - step_s * counts) <= rounding_s * (1 + 1e-9) + _DRIFT * step_s)
    if not even:
        raise DataError(
            "DataFrame, time_s", wanted="times that rise by one step", found="other steps",
            do="Resample the table, split it at gaps, or give fs_hz and drop the column.",
        )  # fmt: skip
    measured_hz = (time_s.size - 1) / float(time_s[-1] - time_s[0])
    # the ends are rounded too: a short table does not tell its rate better than that
    slack = _RATES_DIFFER + 2 * rounding_s / float(time_s[-1] - time_s[0])
    if fs_hz is not None and abs(fs_hz - measured_hz) > slack * measured_hz:
        do = "Leave fs_hz out, or drop the column time_s."
        found = f"{fs_hz:g} Hz"
        raise SettingError("read, fs_hz", wanted=f"{measured_hz:.6g} Hz, as time_s says", found=found, do=do)
    return fs_hz or measured_hz, float(time_s[0])


def _rounding_s(time_s: Floats, steps: Floats) -> float:
    """Worth of the last decimal of times whose steps differ by it; 0 where they hardly do, or no decimal is seen."""
    usual = float(np.median(steps))
    for decimals in range(7):
        if np.allclose(time_s, np.round(time_s, decimals), rtol=1e-14, atol=1e-12):
            last_s = 10.0**-decimals
            return last_s if np.mean(np.abs(steps - usual) > 0.5 * last_s) > _REPEATING else 0.0
    return 0.0
