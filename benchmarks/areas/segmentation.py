"""Presses found in a record: edges against those that the simulation drew."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy import signal

from benchmarks.bench.case import Area, Case, Size, Way, peer
from benchmarks.experts import presses
from benchmarks.simulated_records import (
    FS_HZ,
    LOAD_S,
    NOISE_N,
    PEAK_N,
    PER_RECORD,
    REST_S,
    TRIAL_S,
    Records,
    make_records,
)

LOWER_N, UPPER_N = 0.5, 7.0
MOST_MS = 1000.0
"A press that is not found counts as an edge so far away."
EARLY = "finds activity, which begins before the force window"


def by_force(size: Size) -> Iterator[Case]:
    """Both edges of the force window, from raw force with an offset and noise."""
    from emg2vsa.settings import FilterSettings, ForceChannelSettings, WindowSettings
    from emg2vsa.signals.filters import force_low_pass
    from emg2vsa.signals.force import condition_force

    low = force_low_pass(FilterSettings(), FS_HZ)
    assert low is not None
    for n in size.pick((10, 20), (70, 210, 700)):
        records = make_records(n)

        def ours(records: Records = records) -> list[np.ndarray]:
            found = [
                condition_force(row, FS_HZ, low, ForceChannelSettings(name="Fz"), WindowSettings()).presses
                for row in records.force_n
            ]
            return [np.column_stack([presses.start_s, presses.stop_s]) for presses in found]

        family = "presses found by force"
        ways = [
            Way("emg2vsa", "condition_force", ours, "equal", "with the drift of the zero and the release"),
            *_scripts(records),
        ]
        yield Case(
            f"{family}, {n} trials",
            n,
            "trials of 10 s at 1000 Hz",
            tuple(ways),
            _edge_error,
            "ms, RMS of both edges",
            "the instants at which the simulated force passes 0.5 and 7 N",
            family,
        )


def by_emg(size: Size) -> Iterator[Case]:
    """Onsets of activity by EMG, as onset detectors give them, beside the lower edge by force."""
    from emg2vsa.settings import FilterSettings, ForceChannelSettings, WindowSettings
    from emg2vsa.signals.filters import force_low_pass
    from emg2vsa.signals.force import condition_force

    n = size.pick(1, 5)
    record = make_records(PER_RECORD)
    length = round(n * TRIAL_S * FS_HZ)
    force_n, emg = record.force_n[0][:length], record.emg[0][0, :length]
    low = force_low_pass(FilterSettings(), FS_HZ)

    def ours() -> np.ndarray:
        return condition_force(force_n, FS_HZ, low, ForceChannelSettings(name="Fz"), WindowSettings()).presses.start_s

    ways = [Way("emg2vsa", "condition_force, by force", ours, "as used")]
    for library, name, onsets in _detectors():
        ways.append(Way(library, name, lambda onsets=onsets: onsets(emg), "as used", EARLY))
    yield Case(
        "onsets of presses, each library's own way",
        n,
        "presses",
        tuple(ways),
        lambda found: _onset_scatter(found, _true_s(LOWER_N)[:n]),
        "ms, scatter of the onset",
        "the start of each simulated press; a constant lead is not counted",
    )


def _scripts(records: Records) -> Iterator[Way]:
    """What one writes in a script: zero from the first second, thresholds, first sample that is not below."""
    sos = signal.butter(2, 5.0, fs=FS_HZ, output="sos")
    force_n = np.array(records.force_n)

    def filtered() -> list[np.ndarray]:
        return [_crossings(row) for row in signal.sosfiltfilt(sos, force_n)]

    yield Way(
        "scipy", "expert: rests, tared force, edges, releases at a tenth of the rate",
        lambda: [found["edges"] for found in presses.records(force_n, FS_HZ, (LOWER_N, UPPER_N))], "equal",
    )  # fmt: skip
    yield Way(
        "scipy", "expert: means of ten, sosfiltfilt, crossings",
        lambda: presses.edges(force_n, FS_HZ, (LOWER_N, UPPER_N)), "as used",
        "edges alone; zero from the first second; between samples",
    )  # fmt: skip
    yield Way("scipy", "sosfiltfilt and a threshold", filtered, "as used", "edges alone; zero from the first second")
    yield Way(
        "numpy",
        "a threshold on raw force",
        lambda: [_crossings(row) for row in force_n],
        "as used",
        "edges alone; no filter; zero from the first second",
    )


def _crossings(force_n: np.ndarray) -> np.ndarray:
    """(presses, 2) first sample at or above each edge, s; crossings nearer than 0.25 s are one."""
    tared = force_n - np.median(force_n[: round(FS_HZ)])
    edges = []
    for level in (LOWER_N, UPPER_N):
        above = tared >= level
        at = np.flatnonzero(above[1:] & ~above[:-1]) + 1
        edges.append(at[np.diff(at, prepend=-np.inf) > 0.25 * FS_HZ] / FS_HZ)
    n = min(map(len, edges))
    return np.column_stack([edge[:n] for edge in edges])


def _detectors() -> Iterator[tuple[str, str, Any]]:
    """Library, what is called, and the onsets (s) in one row of EMG."""
    if neurokit := peer("neurokit2"):

        def by_neurokit(row: np.ndarray) -> np.ndarray:
            amplitude = neurokit.emg_amplitude(neurokit.emg_clean(row, sampling_rate=int(FS_HZ)))
            found = neurokit.emg_activation(amplitude, sampling_rate=int(FS_HZ), method="threshold")[1]
            return np.asarray(found["EMG_Onsets"]) / FS_HZ

        yield "NeuroKit2", "emg_activation, threshold", by_neurokit


def _true_s(force_n: float) -> np.ndarray:
    return REST_S + force_n / PEAK_N * LOAD_S + TRIAL_S * np.arange(PER_RECORD)


def _edge_error(found: list[np.ndarray]) -> float:
    """RMS distance of the true edges from the nearest found, ms."""
    true_s = np.column_stack([_true_s(LOWER_N), _true_s(UPPER_N)])
    away = [_nearest_ms(true_s[:, side], edges[:, side]) for edges in found for side in (0, 1)]
    return float(np.sqrt(np.mean(np.concatenate(away) ** 2)))


def _onset_scatter(found_s: np.ndarray, true_s: np.ndarray) -> float:
    """RMS of the onsets about their own median lead over the window's lower edge, ms."""
    if not found_s.size:
        return MOST_MS
    nearest = found_s[np.argmin(np.abs(true_s[:, None] - found_s), axis=1)]
    lead_s = np.median(true_s - nearest)
    return float(np.sqrt(np.mean(_nearest_ms(true_s - lead_s, found_s) ** 2)))


def _nearest_ms(true_s: np.ndarray, found_s: np.ndarray) -> np.ndarray:
    if not found_s.size:
        return np.full(true_s.size, MOST_MS)
    return np.asarray(np.minimum(1e3 * np.min(np.abs(true_s[:, None] - found_s), axis=1), MOST_MS))


AREA = Area(
    name="segmentation",
    question="How exactly, and at what cost, are presses found in a record?",
    parts=(by_force, by_emg),
    peers={"neurokit2": "neurokit2"},
    meaning=(
        f"The simulated force has noise of {1e3 * NOISE_N:g} mN, so raw thresholds are crossed early; a low-pass "
        "mends this and rounds the corner of contact. Ours interpolates between samples, follows the drift of "
        "the zero, finds rests and the release too, and gives the force at its full rate, as the expert's row of "
        "equal work does; others find edges alone. Onset detectors of EMG find the start of "
        "activity, a lead that is taken out; what remains is their scatter."
    ),
)
