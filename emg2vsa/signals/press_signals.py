"""The EMG of a recording as its checks look at it: raw samples, envelopes, where the presses and the rests are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats, Ints


@dataclass(frozen=True)
class Signals:
    """What is looked at: raw samples (n,) in volts by muscle at ``fs_hz``, and where the presses and the rests are.

    presses, rests : (p, 2), (r, 2) first and last-plus-one sample. rest_v : (m,) envelopes at rest, NaN if unknown.
    force_n : (N,) and envelopes_v : (m, N) of the
    presses, evenly sampled at ``envelope_fs_hz`` and cut by ``offsets`` (p + 1,).
    lag_s : force follows EMG so late.
    """

    muscles: tuple[str, ...]
    samples: tuple[Floats, ...]
    fs_hz: float
    presses: Ints
    rests: Ints
    rest_v: Floats
    force_n: Floats
    envelopes_v: Floats
    envelope_fs_hz: float
    offsets: Ints
    lag_s: float = 0.0


def pieces_of(x: Floats, bounds: Ints, at_least: int) -> list[Floats]:
    """Pieces [i, j) (q, 2) of a signal (n,) that have so many samples or more."""
    return [x[i:j] for i, j in bounds.tolist() if j - i >= at_least]


def by_press(values: Floats, offsets: Ints) -> list[Floats]:
    """Values (N,) of each press, by offsets (p + 1,)."""
    return [values[i:j] for i, j in zip(offsets[:-1].tolist(), offsets[1:].tolist(), strict=True)]


def volts(level_v: float) -> str:
    """A level, V, in words: two digits, in V, mV, uV or nV."""
    for scale, unit in ((1.0, "V"), (1e-3, "mV"), (1e-6, "uV"), (1e-9, "nV")):
        if level_v >= scale:
            return f"{level_v / scale:.2g} {unit}" if level_v < 99.5 * scale else f"{level_v / scale:.0f} {unit}"
    return f"{level_v:.1g} V"


def correlation(x: Floats, y: Floats) -> float:
    """Pearson's coefficient of x (n,) and y (m,) over what both have; 0 where one is constant."""
    n = min(x.size, y.size)
    x, y = x[:n] - x[:n].mean(), y[:n] - y[:n].mean()
    norm = float(np.sqrt((x @ x) * (y @ y)))
    return float(x @ y) / norm if norm > 0 else 0.0
