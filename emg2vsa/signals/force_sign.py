"""Is the sign of the force right? A reversed channel shows every release as a press."""

from __future__ import annotations

import numpy as np

from emg2vsa.arrays import Floats, Ints, median
from emg2vsa.signals.quality import SILENT_DB, ratio_db, window_means


def doubt_by_emg(
    force_n: Floats,
    envelopes_v: Floats,
    offsets: Ints,
    rest_v: Floats,
    window_n: tuple[float, float],
    sign: int,
) -> str:
    """Why the ``sign`` of the force seems wrong by what the muscles do, or "".

    Force (N,) and envelopes (m, N) of the presses that ``offsets`` cut; rest_v : (m,) envelopes at rest. Pressing takes
    EMG. Where in the upper half of the force window at least one muscle is below its rest and none above it, both by
    more than ``SILENT_DB`` and in the median of the presses, the rest was the press.
    """
    high = (force_n > sum(window_n) / 2).astype(np.float64)
    with np.errstate(invalid="ignore"):
        high_v = window_means(envelopes_v * high, offsets) / window_means(high[None], offsets)
    known = [row[np.isfinite(row)] for row in ratio_db(high_v, rest_v[:, None])]
    typical_db = [median(row) for row in known if row.size]
    if not typical_db or min(typical_db) > -SILENT_DB or max(typical_db) > SILENT_DB:
        return ""
    return f"force rises while EMG is below its rest; {question(sign)}"


def doubt_by_force(force_n: Floats, window_n: tuple[float, float], sign: int) -> str:
    """Why the ``sign`` of the tared force (n,) of a record without presses seems wrong, or ""."""
    if -force_n.min() < window_n[1] or force_n.max() >= window_n[1]:
        return ""
    return f"force goes down to {force_n.min():.3g} N and up to {force_n.max():.3g} N only; {question(sign)}"


def question(sign: int) -> str:
    """What to ask of whoever wrote the study."""
    return f"is its sign {-sign}?"
