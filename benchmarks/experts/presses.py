"""Edges of presses in force: means of ten samples first, so that the low-pass runs over a tenth of them."""

from __future__ import annotations

import numpy as np
from scipy import signal

MEANS = 10
APART_S = 0.25
"Crossings nearer than this are one."
REST_S = 0.5
"Shorter lulls are no rests."


def edges(force_n: np.ndarray, fs_hz: float, levels_n: tuple[float, ...]) -> list[np.ndarray]:
    """Of rows (r, n) the instants (presses, levels), s, at which force rises through each level, between samples."""
    slow_hz = fs_hz / MEANS
    means = force_n[:, : force_n.shape[1] // MEANS * MEANS].reshape(len(force_n), -1, MEANS).mean(axis=2)
    means -= np.median(means[:, : round(slow_hz)], axis=1, keepdims=True)
    slow = signal.sosfiltfilt(signal.butter(2, 5.0, fs=slow_hz, output="sos"), means)
    return [_rises(row, slow_hz, levels_n) for row in slow]


def records(force_n: np.ndarray, fs_hz: float, levels_n: tuple[float, float]) -> list[dict[str, np.ndarray]]:
    """Of rows (r, n) what a judge of presses needs: force (n,) less a line through its rests and low-passed, rests
    (k, 2) and their levels, edges (p, 2), releases (p,), and how far the zero moved over each press, N."""
    slow_hz = fs_hz / MEANS
    means = force_n[:, : force_n.shape[1] // MEANS * MEANS].reshape(len(force_n), -1, MEANS).mean(axis=2)
    slow = signal.sosfiltfilt(signal.butter(2, 5.0, fs=slow_hz, output="sos"), means)
    return [_record(row, force_n.shape[1], fs_hz, levels_n) for row in slow]


def _record(row: np.ndarray, n: int, fs_hz: float, levels_n: tuple[float, float]) -> dict[str, np.ndarray]:
    slow_hz = fs_hz / MEANS
    calm = np.abs(row - np.median(np.sort(row)[: row.size // 4])) < 0.2 * levels_n[0]
    turns = np.flatnonzero(np.diff(calm, prepend=False, append=False)).reshape(-1, 2)
    rests = turns[np.diff(turns, axis=1)[:, 0] > REST_S * slow_hz]
    level = np.array([np.median(row[first:last]) for first, last in rests])
    tared = row - np.interp(np.arange(row.size), rests.mean(axis=1), level)
    found = _rises(tared, slow_hz, levels_n)
    falls = np.flatnonzero((tared[1:] < levels_n[0]) & (tared[:-1] >= levels_n[0])) / slow_hz
    after = np.minimum(np.searchsorted(falls, found[:, 1]), max(falls.size - 1, 0))
    at = np.searchsorted(rests[:, 0] / slow_hz, found[:, 0])
    moved = np.append(level, np.nan)[np.minimum(at, level.size)] - level[np.maximum(at - 1, 0)]
    middles = (np.arange(row.size) + 0.5 - 0.5 / MEANS) * MEANS
    force = np.interp(np.arange(n), middles, tared)
    return {"force": force, "rests": rests, "levels": level, "edges": found, "release": falls[after], "moved": moved}


def _rises(row: np.ndarray, slow_hz: float, levels_n: tuple[float, ...]) -> np.ndarray:
    found = []
    for level in levels_n:
        at = np.flatnonzero((row[1:] >= level) & (row[:-1] < level))
        at = at[np.diff(at, prepend=-np.inf) > APART_S * slow_hz]
        share = (level - row[at]) / (row[at + 1] - row[at])
        found.append((at + share + 0.5 - 0.5 / MEANS) / slow_hz)
    n = min(map(len, found))
    return np.column_stack([each[:n] for each in found])
