"""Continuous records of ten presses each: two muscles whose level is known, and a force of known edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats, Ints

FS_HZ, TRIAL_S, PER_RECORD, MUSCLES = 1000.0, 10.0, 10, ("EDC", "FDS")
REST_S, LOAD_S, HOLD_S, RELEASE_S = 3.0, 2.7, 0.3, 1.0
"Force 0 to 7.6 N in 2.7 s, so that 0.5 to 7 N take about 2.3 s of every 10 s."
PEAK_N, OFFSET_N, NOISE_N = 7.6, 0.3, 0.02


@dataclass(frozen=True)
class Records:
    """emg : per record (2, n) volts. force_n : per record (n,). first, counts : envelope instants per record."""

    emg: list[Floats]
    force_n: list[Floats]
    first: Ints
    counts: Ints


def make_records(n_trials: int) -> Records:
    """``n_trials`` presses, a multiple of ten, whose trials start every 10 s."""
    rng = np.random.default_rng(1)
    press_n = press_at(np.arange(round(TRIAL_S * FS_HZ)))
    level_v = np.tile(_level(press_n), PER_RECORD)
    emg = [level_v * rng.standard_normal((len(MUSCLES), level_v.size)) for _ in range(n_trials // PER_RECORD)]
    force = [np.tile(press_n, PER_RECORD) + NOISE_N * rng.standard_normal(level_v.size) + OFFSET_N for _ in emg]
    start = round((REST_S + 0.5 / PEAK_N * LOAD_S) * FS_HZ) // 10 * 10
    first = np.arange(PER_RECORD) * press_n.size + start
    return Records(emg, force, first, np.full(PER_RECORD, round(6.5 / PEAK_N * LOAD_S * FS_HZ / 10)))


def press_at(samples: Ints) -> Floats:
    """Force (n,) of a press without offset and noise, N, at samples from the start of its trial."""
    knots_s = np.cumsum([0, REST_S, LOAD_S, HOLD_S, RELEASE_S, TRIAL_S])
    return np.interp(samples / FS_HZ, knots_s, [0.0, 0.0, PEAK_N, PEAK_N, 0.0, 0.0])


def level_at(samples: Ints) -> Floats:
    """SD (n,) of the EMG, V, at samples from the start of a trial."""
    return _level(press_at(samples))


def _level(force_n: Floats) -> Floats:
    return 2e-6 + 30e-6 * np.log1p(force_n)


def as_trials(records: Records) -> Floats:
    """The EMG cut every 10 s: (trials x muscles, samples), contiguous."""
    size = round(TRIAL_S * FS_HZ)
    cut = np.stack(records.emg).reshape(len(records.emg), len(MUSCLES), PER_RECORD, size).swapaxes(1, 2)
    return np.ascontiguousarray(cut.reshape(-1, size))
