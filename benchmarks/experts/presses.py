"""Edges of presses in force: means of ten samples first, so that the low-pass runs over a tenth of them."""

from __future__ import annotations

import numpy as np
from scipy import signal

MEANS = 10
APART_S = 0.25
"Crossings nearer than this are one."


def edges(force_n: np.ndarray, fs_hz: float, levels_n: tuple[float, ...]) -> list[np.ndarray]:
    """Of rows (r, n) the instants (presses, levels), s, at which force rises through each level, between samples."""
    slow_hz = fs_hz / MEANS
    means = force_n[:, : force_n.shape[1] // MEANS * MEANS].reshape(len(force_n), -1, MEANS).mean(axis=2)
    means -= np.median(means[:, : round(slow_hz)], axis=1, keepdims=True)
    slow = signal.sosfiltfilt(signal.butter(2, 5.0, fs=slow_hz, output="sos"), means)
    return [_rises(row, slow_hz, levels_n) for row in slow]


def _rises(row: np.ndarray, slow_hz: float, levels_n: tuple[float, ...]) -> np.ndarray:
    found = []
    for level in levels_n:
        at = np.flatnonzero((row[1:] >= level) & (row[:-1] < level))
        at = at[np.diff(at, prepend=-np.inf) > APART_S * slow_hz]
        share = (level - row[at]) / (row[at + 1] - row[at])
        found.append((at + share + 0.5 - 0.5 / MEANS) / slow_hz)
    n = min(map(len, found))
    return np.column_stack([each[:n] for each in found])
