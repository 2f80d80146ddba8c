"""From raw records to judged trials: the whole stage, beside the script that one writes with SciPy."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy import signal

from benchmarks.areas.segmentation import LOWER_N, UPPER_N
from benchmarks.bench.case import Area, Case, Size, Way, peer
from benchmarks.experts.filters import by_scipy, memory_samples
from benchmarks.experts.presses import edges
from benchmarks.simulated_records import FS_HZ, MUSCLES, PER_RECORD, Records, level_at, make_records, press_at
from emg2vsa.settings import FilterSettings
from emg2vsa.signals.envelope import smoother
from emg2vsa.signals.filters import band_pass, force_low_pass

STEP = 10
"Samples between two of an envelope."
FEWER = "no verdicts, hum, floor, lag or quality"


def judged_trials(size: Size) -> Iterator[Case]:
    """Continuous records of two muscles and force, ten presses each."""
    for n in size.pick((10, 20), (20, 70, 210)):
        records = make_records(n)
        ways = [
            Way("emg2vsa", "extract_trials", lambda r=records: _ours(r), "equal", "finds, conditions and judges"),
            Way("scipy", "expert: envelopes in windows alone", lambda r=records: _expert(r), "as used", FEWER),
            Way("scipy", "script: filter all, threshold, cut", lambda r=records: _script(r), "as used", FEWER),
        ]
        if n <= size.pick(10, 70) and (neurokit := peer("neurokit2")):
            ways.append(
                Way(
                    "NeuroKit2",
                    "script: emg_clean, amplitude, threshold",
                    lambda r=records: _neurokit(neurokit, r),
                    "as used",
                    FEWER,
                )
            )
        family = "records to judged trials"
        yield Case(
            f"{family}, {n} trials",
            n,
            "trials of 10 s x 3 channels at 1000 Hz",
            tuple(ways),
            _activity_error,
            "RMS, relative",
            "mean activity in the window as simulated, one factor for all presses",
            family,
        )


def _ours(records: Records) -> np.ndarray:
    """Mean activity (presses,) in the force window; NaN for a press that was not found or rejected."""
    from emg2vsa.extraction.extract import extract_trials
    from emg2vsa.recordings import Channel
    from emg2vsa.settings import CocontractionSettings, ForceChannelSettings, WindowSettings

    means = []
    for emg, force_n in zip(records.emg, records.force_n, strict=True):
        trials = extract_trials(
            {m: Channel(m, row, "V", FS_HZ, 0.0, "V") for m, row in zip(MUSCLES, emg, strict=True)},
            Channel("Fz", force_n, "N", FS_HZ, 0.0, "N"),
            participant="P01",
            specimen="S1",
            filters=FilterSettings(),
            cocontraction=CocontractionSettings(),
            window=WindowSettings(),
            force_channel=ForceChannelSettings(name="Fz"),
        )
        offsets = trials.offsets
        own = np.add.reduceat(trials.activity, offsets[:-1]) / np.diff(offsets)
        means.append(_as_ten(np.where(trials.verdict == "rejected", np.nan, own)))
    return np.concatenate(means)


def _expert(records: Records) -> np.ndarray:
    """Presses by means of ten samples, then envelopes in windows as long as the longest press, of all channels."""
    filters = FilterSettings()
    sos, kernel = band_pass(filters, FS_HZ).sos, smoother(filters, FS_HZ, 10)
    memory, means = memory_samples(sos, 1e-10), []
    rises = edges(np.stack(records.force_n), FS_HZ, (LOWER_N, UPPER_N))
    for emg, found in zip(records.emg, rises, strict=True):
        first, last = np.ceil(found * FS_HZ).astype(np.int64).T
        n_out = int(np.max(last - first)) // STEP + 1
        envelopes = by_scipy(np.asarray(emg), first, n_out, STEP, sos, kernel, memory).sum(axis=0)
        inside = np.arange(n_out) * STEP < (last - first)[:, None]
        means.append(_as_ten(np.where(inside, envelopes, 0).sum(axis=1) / inside.sum(axis=1)))
    return np.concatenate(means)


def _script(records: Records) -> np.ndarray:
    filters = FilterSettings()
    low = force_low_pass(filters, FS_HZ)
    assert low is not None
    sos, taps = band_pass(filters, FS_HZ).sos, smoother(filters, FS_HZ, 10).taps
    means = []
    for emg, raw_n in zip(records.emg, records.force_n, strict=True):
        envelopes = signal.oaconvolve(np.abs(signal.sosfiltfilt(sos, emg)), taps[None], mode="same", axes=-1)
        means.append(_in_windows(envelopes.sum(axis=0), signal.sosfiltfilt(low.sos, raw_n)))
    return np.concatenate(means)


def _neurokit(neurokit: Any, records: Records) -> np.ndarray:
    def envelope(row: np.ndarray) -> np.ndarray:
        return np.asarray(neurokit.emg_amplitude(neurokit.emg_clean(row, sampling_rate=int(FS_HZ))))

    means = []
    for emg, raw_n in zip(records.emg, records.force_n, strict=True):
        filtered_n = neurokit.signal_filter(raw_n, FS_HZ, highcut=5.0, method="butterworth", order=2)
        means.append(_in_windows(envelope(emg[0]) + envelope(emg[1]), filtered_n))
    return np.concatenate(means)


def _in_windows(activity: np.ndarray, force_n: np.ndarray) -> np.ndarray:
    tared = force_n - np.median(force_n[: round(FS_HZ)])
    starts, stops = (np.flatnonzero((tared[1:] >= edge) & (tared[:-1] < edge)) + 1 for edge in (LOWER_N, UPPER_N))
    windows = zip(starts, stops, strict=False)
    return _as_ten(np.array([activity[start:stop].mean() for start, stop in windows]))


def _as_ten(means: np.ndarray) -> np.ndarray:
    return means if means.size == PER_RECORD else np.full(PER_RECORD, np.nan)


def _activity_error(means: np.ndarray) -> float:
    """RMS of the relative errors; a press that was not found counts as 1."""
    at = np.arange(10_000)
    force_n = press_at(at)
    loading = (at < 5_700) & (force_n >= LOWER_N) & (force_n <= UPPER_N)
    truth = len(MUSCLES) * level_at(at)[loading].mean()
    found = np.isfinite(means)
    if not np.any(found):
        return 1.0
    scaled = means * (truth / np.mean(means[found]))
    return float(np.sqrt(np.mean(np.where(found, scaled / truth - 1, 1.0) ** 2)))


AREA = Area(
    name="records",
    question="What does a raw record cost from its samples to judged trials?",
    parts=(judged_trials,),
    peers={"neurokit2": "neurokit2"},
    meaning=(
        "Our stage filters EMG in the windows alone, and spends the rest on what a script leaves out: hum, the "
        "level at rest, lag, quality and a verdict for each press. The error is the scatter of the mean activity "
        "of a press, which the length of the window and the EMG itself set; it is equal where no press is lost. "
        "No script judges, so no row is of equal work."
    ),
)
