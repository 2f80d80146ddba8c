"""Envelopes in windows of a record: SciPy with windows as short as the filter allows, and one loop of Numba."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import signal

from benchmarks.bench.case import peer


def memory_samples(sos: np.ndarray, left: float) -> int:
    """Samples until the slowest pole of second-order sections has decayed to ``left``."""
    return int(np.ceil(np.log(left) / np.log(np.max(np.abs(signal.sos2zpk(sos)[1])))))


def by_scipy(
    emg: np.ndarray, first: np.ndarray, n_out: int, step: int, sos: np.ndarray, kernel: Any, memory: int
) -> np.ndarray:
    """Envelopes (rows, windows, n_out) of rows (rows, n): windows wider by the memory, both passes without padding, and
    taps at the samples that are kept alone."""
    reach, taps = memory + kernel.before, kernel.taps
    length = step * (n_out - 1) + taps.size + 2 * memory
    rows = np.lib.stride_tricks.sliding_window_view(emg, length, axis=1)[:, first - reach]
    back = signal.sosfilt(sos, signal.sosfilt(sos, rows)[..., memory:][..., ::-1])[..., ::-1][
        ..., : length - 2 * memory
    ]
    rectified = back * back if kernel.squared else np.abs(back)
    smooth = np.lib.stride_tricks.sliding_window_view(rectified, taps.size, axis=-1)[..., ::step, :] @ taps
    return np.asarray(np.sqrt(smooth) if kernel.squared else smooth)


def by_numba() -> Any:
    """The same in one compiled loop, all rows and windows of a record in lanes side by side; None without Numba."""
    numba = peer("numba")
    if numba is None:
        return None

    compiled = numba.njit(error_model="numpy", fastmath={"contract"})

    @compiled
    def cut(samples: np.ndarray, starts: np.ndarray, length: int) -> np.ndarray:
        x = np.empty((length, starts.size))
        for t in range(length):
            for k in range(starts.size):
                x[t, k] = samples[starts[k] + t]
        return x

    @compiled
    def filtered(x: np.ndarray, sos: np.ndarray, backwards: bool) -> None:
        z = np.zeros((len(sos), 2, x.shape[1]))
        for i in range(len(x)):
            t = len(x) - 1 - i if backwards else i
            for s in range(len(sos)):
                b0, b1, b2, a1, a2 = sos[s, 0], sos[s, 1], sos[s, 2], sos[s, 4], sos[s, 5]
                for k in range(x.shape[1]):
                    v = x[t, k]
                    y = b0 * v + z[s, 0, k]
                    z[s, 0, k] = b1 * v - a1 * y + z[s, 1, k]
                    z[s, 1, k] = b2 * v - a2 * y
                    x[t, k] = y

    @compiled
    def smoothed(x: np.ndarray, taps: np.ndarray, n_out: int, step: int) -> np.ndarray:
        out = np.zeros((n_out, x.shape[1]))
        for i in range(n_out):
            for j in range(taps.size):
                for k in range(x.shape[1]):
                    out[i, k] += taps[j] * x[i * step + j, k]
        return out

    def run(
        emg: np.ndarray, first: np.ndarray, n_out: int, step: int, sos: np.ndarray, kernel: Any, memory: int
    ) -> np.ndarray:
        taps = kernel.taps
        starts = np.arange(len(emg))[:, None] * emg.shape[1] + first - kernel.before - memory
        x = cut(emg.reshape(-1), starts.reshape(-1), step * (n_out - 1) + taps.size + 2 * memory)
        filtered(x, sos, False)
        filtered(x, sos, True)
        x = x[memory:-memory]
        smooth = smoothed(x * x if kernel.squared else np.abs(x), taps, n_out, step)
        return np.asarray((np.sqrt(smooth) if kernel.squared else smooth).T.reshape(len(emg), len(first), n_out))

    return run
