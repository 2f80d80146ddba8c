"""Two signals on one time axis: which EMG samples belong to a loading phase, and the force at those instants."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, Ints
from emg2vsa.signals.rest import Rest

REST_S = 0.5
"EMG at rest is taken from the middle of a rest, for at most so long."
REST_PIECES = 3
"... of the first, the middle and the last rest of the record."


@dataclass(frozen=True)
class Clock:
    """Sample i of a signal of n samples shows what happened at ``start_s + i / fs_hz``: delays are already removed."""

    start_s: float
    fs_hz: float
    n_samples: int

    def time_s(self, index: Floats | Ints) -> Floats:
        """Times, s, of samples by their index (n,), whole or not."""
        return np.asarray(self.start_s + index / self.fs_hz, dtype=np.float64)

    def index(self, time_s: Floats) -> Floats:
        """Index (n,), not whole, of times (n,), s: the inverse of ``time_s``."""
        return np.asarray((time_s - self.start_s) * self.fs_hz, dtype=np.float64)


@dataclass(frozen=True)
class Instants:
    """EMG samples ``first[w] + step * arange(counts[w])`` of every window.

    covered : (w,) the record holds all that was asked for.
    """

    first: Ints
    counts: Ints
    step: int
    covered: NDArray[np.bool_]

    @cached_property
    def offsets(self) -> Ints:
        """(w + 1,): window i holds the instants [offsets[i], offsets[i + 1]) of all."""
        return np.asarray(np.concatenate((np.zeros(1, np.int64), np.cumsum(self.counts))), dtype=np.int64)

    @property
    def last(self) -> Ints:
        """(w,) last sample of each window; the first where it has none."""
        return np.asarray(self.first + self.step * np.maximum(self.counts - 1, 0), dtype=np.int64)

    @cached_property
    def samples(self) -> Ints:
        """Indices (N,) of all windows, one after the other."""
        within = np.arange(int(self.counts.sum())) - np.repeat(self.offsets[:-1], self.counts)
        return np.repeat(self.first, self.counts) + self.step * within


def instants_between(start_s: Floats, stop_s: Floats, emg: Clock, force: Clock, step: int) -> Instants:
    """Every ``step``-th EMG sample, counted from the first of the record, that lies in [start_s, stop_s] (w,), s.

    Samples outside the EMG or the force record do not exist; a window that asks for any is not covered.
    """
    wanted_first = np.ceil(emg.index(start_s) / step - 1e-9).astype(np.int64)
    wanted_last = np.floor(emg.index(stop_s) / step + 1e-9).astype(np.int64)
    bounds = emg.index(force.time_s(np.array([0, force.n_samples - 1]))) / step
    lowest = max(0, int(np.ceil(bounds[0] - 1e-9)))
    highest = min((emg.n_samples - 1) // step, int(np.floor(bounds[1] + 1e-9)))
    first, last = np.clip(wanted_first, lowest, None), np.clip(wanted_last, None, highest)
    counts = np.maximum(last - first + 1, 0)
    covered = (first == wanted_first) & (last == wanted_last)
    return Instants(np.where(counts > 0, first, 0) * step, counts, step, covered)


def force_at(force_n: Floats, instants: Instants, emg: Clock, force: Clock) -> Floats:
    """Force (N,) at the instants, from its own samples (n,)."""
    position = force.index(emg.time_s(instants.samples))
    return _cubic_at(force_n, np.clip(position, 0, force.n_samples - 1))


def rest_instants(rest: Rest, emg: Clock, force: Clock, step: int) -> Instants:
    """The middles of up to three rests, as far as the EMG record covers them."""
    chosen = np.unique(np.linspace(0, rest.level_n.size - 1, min(REST_PIECES, rest.level_n.size)).astype(np.int64))
    start_s, stop_s = force.time_s(rest.start[chosen]), force.time_s(rest.stop[chosen] - 1)
    middle, half = (start_s + stop_s) / 2, np.minimum(stop_s - start_s, REST_S) / 2
    found = instants_between(middle - half, middle + half, emg, force, step)
    kept = found.counts > 0
    return Instants(found.first[kept], found.counts[kept], step, found.covered[kept])


def rest_samples(rest: Rest, emg: Clock, force: Clock) -> tuple[Ints, Ints]:
    """First and last-plus-one EMG sample (r,), (r,) of every rest, as far as the EMG record covers it."""
    start = np.ceil(emg.index(force.time_s(rest.start))).astype(np.int64)
    stop = np.floor(emg.index(force.time_s(rest.stop - 1))).astype(np.int64) + 1
    start, stop = np.clip(start, 0, emg.n_samples), np.clip(stop, 0, emg.n_samples)
    kept = stop > start
    return start[kept], stop[kept]


def _cubic_at(samples: Floats, position: Floats) -> Floats:
    """Samples (n,), n >= 4, at fractional positions (k,) within [0, n - 1]: the cubic through the four nearest.

    Exact at whole positions. For a signal low-passed at f and sampled at fs the error is at most (3/128)(2 pi f/fs)^4
    of its amplitude: 1e-5 for 5 Hz at 200 Hz, 2e-8 at 1000 Hz (linear: 3e-3 and 1e-4).
    """
    left = np.clip(np.floor(position).astype(np.int64) - 1, 0, samples.size - 4)
    x = position - left
    a, b, c, d = (samples[left + k] for k in range(4))
    x1, x2, x3 = x - 1, x - 2, x - 3
    return np.asarray(-a * x1 * x2 * x3 / 6 + b * x * x2 * x3 / 2 - c * x * x1 * x3 / 2 + d * x * x1 * x2 / 6)


SINC_SAMPLES, SINC_BETA, SINC_BLOCK = 32, 8.0, 4096
"Samples on either side of an instant that band-limited interpolation uses, their Kaiser window, instants at a time."


def band_limited_at(samples: Floats, position: Floats) -> Floats:
    """Samples (n,) at fractional positions (k,) within [0, n - 1], by a sinc under a Kaiser window.

    For a signal below 0.9 of half its rate the error is below 1e-3 of its amplitude, 32 samples and more from the ends;
    beyond them the first and the last sample go on.
    """
    values = np.empty(position.size)
    reach = np.arange(1 - SINC_SAMPLES, SINC_SAMPLES + 1)
    for begin in range(0, position.size, SINC_BLOCK):
        here = position[begin : begin + SINC_BLOCK]
        left = np.floor(here).astype(np.int64)
        away = (here - left)[:, None] - reach
        window = np.i0(SINC_BETA * np.sqrt(np.maximum(1 - (away / SINC_SAMPLES) ** 2, 0))) / np.i0(SINC_BETA)
        near = samples[np.clip(left[:, None] + reach, 0, samples.size - 1)]
        values[begin : begin + SINC_BLOCK] = np.einsum("ij,ij->i", np.sinc(away) * window, near)
    return values
