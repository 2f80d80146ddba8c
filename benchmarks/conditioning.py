"""Conditioning of 700 trials against its peers, in time and in error; and what the default chain does to b.

``python -m benchmarks.conditioning [--trials 700] [--fits 1500] [--repeats 3]``. Times are CPU seconds,
the best of interleaved repeats, so compare their ratios.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pyemgpipeline as peer
from scipy import signal

from benchmarks.slope_of_b import print_slope_table
from emg2vsa.arrays import Floats, Ints
from emg2vsa.extraction.extract import extract_trials
from emg2vsa.recordings import Channel
from emg2vsa.settings import CocontractionSettings, FilterSettings, ForceChannelSettings, WindowSettings
from emg2vsa.signals.envelope import decimation, envelopes_at, smoother
from emg2vsa.signals.filters import band_pass, force_low_pass

FS_HZ, TRIAL_S, PER_RECORD, MUSCLES = 1000.0, 10.0, 10, ("EDC", "FDS")
REST_S, LOAD_S, HOLD_S, RELEASE_S = 3.0, 2.7, 0.3, 1.0
"Force 0 to 7.6 N in 2.7 s, so that 0.5 to 7 N take about 2.3 s of every 10 s."


@dataclass(frozen=True)
class Records:
    """emg : per record (2, n) volts. force_n : per record (n,). first, counts : envelope instants per record."""

    emg: list[Floats]
    force_n: list[Floats]
    first: Ints
    counts: Ints


def make_records(n_trials: int) -> Records:
    """Continuous records of ten presses each, whose trials start every 10 s."""
    rng = np.random.default_rng(1)
    t = np.arange(round(TRIAL_S * FS_HZ)) / FS_HZ
    knots_s = np.cumsum([0, REST_S, LOAD_S, HOLD_S, RELEASE_S, TRIAL_S])
    press_n = np.interp(t, knots_s, [0.0, 0.0, 7.6, 7.6, 0.0, 0.0])
    size = t.size * PER_RECORD
    level_v = np.tile(2e-6 + 30e-6 * np.log1p(press_n), PER_RECORD)
    emg = [level_v * rng.standard_normal((len(MUSCLES), size)) for _ in range(n_trials // PER_RECORD)]
    force = [np.tile(press_n, PER_RECORD) + 0.02 * rng.standard_normal(size) + 0.3 for _ in emg]
    start = round((REST_S + 0.5 / 7.6 * LOAD_S) * FS_HZ) // 10 * 10
    first = np.arange(PER_RECORD) * t.size + start
    return Records(emg, force, first, np.full(PER_RECORD, round(6.5 / 7.6 * LOAD_S * FS_HZ / 10)))


def windows_only(records: Records, filters: FilterSettings) -> Floats:
    """Ours, EMG alone: (trials, muscles, instants)."""
    step = decimation(FS_HZ, filters.output_fs_hz)
    band, kernel = band_pass(filters, FS_HZ), smoother(filters, FS_HZ, step)
    rows = [envelopes_at(tuple(emg), records.first, records.counts, step, band, kernel) for emg in records.emg]
    return np.concatenate([row.reshape(len(MUSCLES), PER_RECORD, -1).swapaxes(0, 1) for row in rows])


def whole_stage(records: Records, filters: FilterSettings) -> int:
    """Ours, the stage: force tared, presses found, EMG conditioned, quality, verdicts; how many trials are ok."""
    n_ok = 0
    for emg, force_n in zip(records.emg, records.force_n, strict=True):
        trials = extract_trials(
            {m: Channel(m, row, "V", FS_HZ, 0.0, "V") for m, row in zip(MUSCLES, emg, strict=True)},
            Channel("Fz", force_n, "N", FS_HZ, 0.0, "N"),
            participant="P01",
            specimen="S1",
            filters=filters,
            cocontraction=CocontractionSettings(),
            window=WindowSettings(),
            force_channel=ForceChannelSettings(name="Fz"),
        )
        n_ok += int(np.sum(trials.verdict == "ok"))
    return n_ok


def as_trials(records: Records) -> Floats:
    """The same EMG cut every 10 s: (trials x muscles, samples), contiguous."""
    size = round(TRIAL_S * FS_HZ)
    cut = np.stack(records.emg).reshape(len(records.emg), len(MUSCLES), PER_RECORD, size).swapaxes(1, 2)
    return np.ascontiguousarray(cut.reshape(-1, size))


def scipy_batch(rows: Floats, filters: FilterSettings) -> Floats:
    band, kernel = band_pass(filters, FS_HZ), smoother(filters, FS_HZ, 10)
    filtered = signal.sosfiltfilt(band.sos, rows, axis=-1)
    return np.asarray(signal.oaconvolve(np.abs(filtered), kernel.taps[None], mode="same", axes=-1))


def scipy_loop(rows: Floats, filters: FilterSettings) -> Floats:
    return np.concatenate([scipy_batch(rows[i : i + 2], filters) for i in range(0, len(rows), 2)])


def scipy_force(records: Records, filters: FilterSettings) -> Floats:
    low = force_low_pass(filters, FS_HZ)
    assert low is not None
    force_n = np.stack(records.force_n).reshape(-1, round(TRIAL_S * FS_HZ))
    return np.asarray(signal.sosfiltfilt(low.sos, force_n, axis=-1))


def peer_package(rows: Floats) -> Floats:
    done = []
    for i in range(0, len(rows), len(MUSCLES)):
        trial = peer.wrappers.EMGMeasurement(rows[i : i + len(MUSCLES)].T, hz=FS_HZ)
        trial.apply_dc_offset_remover()
        trial.apply_bandpass_filter(bf_order=4, bf_cutoff_fq_lo=10, bf_cutoff_fq_hi=450)
        trial.apply_full_wave_rectifier()
        trial.apply_linear_envelope(le_order=4, le_cutoff_fq=20)
        done.append(trial.data.T)
    return np.concatenate(done)


def best_of(repeats: int, runs: dict[str, Callable[[], object]]) -> dict[str, float]:
    """Least CPU seconds of each, the repeats interleaved."""
    best = dict.fromkeys(runs, float("inf"))
    for _ in range(repeats):
        for name, run in runs.items():
            begin = time.process_time()
            run()
            best[name] = min(best[name], time.process_time() - begin)
    return best


def print_time_table(n_trials: int, repeats: int) -> None:
    filters = FilterSettings()
    records = make_records(n_trials)
    n_trials = len(records.emg) * PER_RECORD
    rows = as_trials(records)
    few = rows[: 2 * min(n_trials, 100)]
    instants = int(records.first[0]) + 10 * np.arange(int(records.counts[0]))

    def error(envelopes_v: Floats) -> float:
        ours = windows_only(records, filters).reshape(-1, instants.size)[: len(envelopes_v)]
        return float(np.max(np.abs(envelopes_v[:, instants] - ours)) / np.max(ours))

    runs: dict[str, Callable[[], object]] = {
        "emg2vsa, EMG in its windows": lambda: windows_only(records, filters),
        "scipy, 2-D batch": lambda: scipy_batch(rows, filters),
        "scipy, loop over trials": lambda: scipy_loop(rows, filters),
        "pyemgpipeline": lambda: peer_package(few),
        "emg2vsa, records to judged trials": lambda: whole_stage(records, filters),
        "scipy, 2-D batch with force": lambda: (scipy_batch(rows, filters), scipy_force(records, filters)),
    }
    seconds = best_of(repeats, runs)
    seconds["pyemgpipeline"] *= len(rows) / len(few)
    errors = {
        "scipy, 2-D batch": f"{error(scipy_batch(rows, filters)):.1e}",
        "scipy, loop over trials": f"{error(scipy_loop(rows, filters)):.1e}",
        "pyemgpipeline": f"{error(peer_package(few)):.1e} (another envelope)",
    }
    ours = seconds["emg2vsa, EMG in its windows"]
    print(f"{n_trials} trials of {TRIAL_S:g} s x {len(MUSCLES)} channels at {FS_HZ:g} Hz; {repeats} repeats")
    print(f"{'':36}{'ms/trial':>9}{'x ours':>8}  envelope against ours, of its maximum")
    for name, value in seconds.items():
        print(f"{name:36}{1e3 * value / n_trials:9.3f}{value / ours:8.1f}  {errors.get(name, '')}")
    print(f"judged ok: {whole_stage(records, filters)} of {n_trials}\n")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=700, help="trials timed, a multiple of ten")
    parser.add_argument("--fits", type=int, default=1500, help="trials simulated for the bias of b")
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    print_time_table(max(options.trials, PER_RECORD), options.repeats)
    print_slope_table(options.fits)


if __name__ == "__main__":
    main()
