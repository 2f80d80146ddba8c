"""EMG and force conditioned: band-pass and envelope in the force windows, RMS envelope, force low-pass."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from scipy import signal

from benchmarks.bench.case import Area, Case, Size, Way, peer
from benchmarks.experts.filters import by_numba, by_scipy, memory_samples
from benchmarks.simulated_records import FS_HZ, MUSCLES, PER_RECORD, Records, as_trials, level_at, make_records

LONGDOUBLE = "the same filters and kernel in 80-bit arithmetic, run over the whole record"
STEP = 10
"Samples between outputs: 100 Hz."
CUT = "windows, wider on both sides by the filter's memory"
BYTES = "the same bytes on every processor"
records_of = cache(make_records)


def emg_in_windows(size: Size) -> Iterator[Case]:
    """Equal work: the same envelopes at the same instants, by every library that filters."""
    from emg2vsa.settings import FilterSettings

    for n in size.pick((10, 20), (70, 210, 700)):
        yield _envelopes(n, FilterSettings(), "EMG envelopes in the force windows", _peers)
    yield _envelopes(size.pick(10, 210), FilterSettings(envelope="rms"), "RMS envelopes in the force windows", _peers)


def whole_records(size: Size) -> Iterator[Case]:
    """Equal work on the whole record: one filtered sample for each sample of input."""
    from emg2vsa.settings import FilterSettings
    from emg2vsa.signals.filters import band_pass, force_low_pass
    from emg2vsa.signals.windowed import filter_record

    filters = FilterSettings()
    records = records_of(size.pick(10, 100))
    low = force_low_pass(filters, FS_HZ)
    assert low is not None
    for name, iir, rows in (
        ("EMG band-pass of whole records", band_pass(filters, FS_HZ), [row for emg in records.emg for row in emg]),
        ("force low-pass of whole records", low, records.force_n),
    ):
        together = np.array(rows)
        truth = _forward_backward(rows[0], iir.sos, iir.pad_samples)

        def ours(rows: Any = rows, iir: Any = iir) -> np.ndarray:
            return np.array([filter_record(row, iir) for row in rows])

        yield Case(
            name,
            len(rows),
            "records of 100 s at 1000 Hz",
            (
                Way("emg2vsa", "filter_record", ours, "equal"),
                Way("scipy", "sosfiltfilt, 2-D batch", lambda x=together, f=iir: signal.sosfiltfilt(f.sos, x), "equal"),
                *_sections_of_peers(together, iir),
            ),
            lambda found, truth=truth: _relative(found[0], truth),
            "relative",
            "the same sections in 80-bit arithmetic, first record",
        )


def as_people_use_them(size: Size) -> Iterator[Case]:
    """Each library's documented recipe from raw EMG to its envelope, against the level that the simulation drew."""
    from emg2vsa.settings import FilterSettings

    records = records_of(size.pick(10, 50))
    rows = as_trials(records)
    instants = _instants(records)
    level_v = level_at(instants)
    ways = [
        Way("emg2vsa", "envelopes_at, windows at 100 Hz", lambda: _ours(records, FilterSettings()), "as used"),
        Way(
            "emg2vsa",
            "envelopes_at, RMS 100 ms",
            lambda: _ours(records, FilterSettings(envelope="rms")),
            "as used",
            "windows at 100 Hz",
        ),
        Way(
            "scipy",
            "sosfiltfilt, abs, FIR over whole trials",
            lambda: _scipy_whole(rows, FilterSettings()),
            "as used",
            "10 s at 1000 Hz of each trial",
            lambda found: _level_error(found[:, instants], level_v),
        ),
    ]
    for library, name, recipe in _recipes():
        ways.append(
            Way(
                library,
                name,
                lambda recipe=recipe: np.array([recipe(row) for row in rows]),
                "as used",
                "10 s at 1000 Hz of each trial",
                lambda found: _level_error(found[:, instants], level_v),
            )
        )
    yield Case(
        "from raw EMG to the level of a press, as each library shows it",
        len(rows),
        "trials x muscles",
        tuple(ways),
        lambda found: _level_error(found.reshape(-1, instants.size), level_v),
        "RMS, relative to the level",
        "the level of EMG that the simulation drew, each way scaled by its own mean",
    )


def _envelopes(n_trials: int, filters: Any, family: str, peers: Callable[..., Iterator[Way]]) -> Case:
    records = records_of(n_trials)
    return Case(
        f"{family}, {n_trials} trials",
        n_trials,
        "trials of 10 s x 2 muscles at 1000 Hz",
        (
            Way("emg2vsa", "envelopes_at", lambda: _ours(records, filters), "equal"),
            *peers(records, filters),
        ),
        lambda found: _relative(found[:PER_RECORD], _exact(records, filters)),
        "relative",
        LONGDOUBLE,
        family,
        **_least(records, filters),
    )


def _least(records: Records, filters: Any) -> dict[str, float]:
    """Bytes that any way reads and writes at least, and the flops of both passes in windows and of the taps."""
    from emg2vsa.signals.envelope import smoother
    from emg2vsa.signals.filters import band_pass

    band, kernel = band_pass(filters, FS_HZ), smoother(filters, FS_HZ, STEP)
    rows, n_out = len(records.emg) * PER_RECORD * len(MUSCLES), int(records.counts[0])
    inner = STEP * (n_out - 1) + kernel.taps.size
    read = inner + 2 * memory_samples(band.sos, 1e-10)
    flops = 9 * len(band.sos) * (2 * read - (read - inner) // 2) + inner + 2 * n_out * kernel.taps.size
    return {"bytes_moved": 8.0 * rows * (read + n_out), "flops": float(rows * flops)}


def _ours(records: Records, filters: Any) -> np.ndarray:
    """(trials, muscles, instants)."""
    from emg2vsa.signals.envelope import envelopes_at, smoother
    from emg2vsa.signals.filters import band_pass

    band, kernel = band_pass(filters, FS_HZ), smoother(filters, FS_HZ, STEP)
    found = [envelopes_at(tuple(emg), records.first, records.counts, STEP, band, kernel) for emg in records.emg]
    return np.concatenate([row.reshape(len(MUSCLES), PER_RECORD, -1).swapaxes(0, 1) for row in found])


def _peers(records: Records, filters: Any) -> Iterator[Way]:
    """Our other engine, and two ways of an expert."""
    from emg2vsa.signals.envelope import smoother
    from emg2vsa.signals.filters import band_pass

    band, kernel = band_pass(filters, FS_HZ), smoother(filters, FS_HZ, STEP)
    compiled, n_out = by_numba(), int(records.counts[0])

    def each(way: Callable[..., np.ndarray], left: float) -> Callable[[], np.ndarray]:
        def run() -> np.ndarray:
            memory = memory_samples(band.sos, left)
            found = [way(emg, records.first, n_out, STEP, band.sos, kernel, memory) for emg in records.emg]
            return np.concatenate([rows.swapaxes(0, 1) for rows in found])

        return run

    if compiled is not None:
        own = replace(filters, engine="compiled")
        yield Way("emg2vsa", 'envelopes_at, engine = "compiled"', lambda: _ours(records, own), "equal", BYTES)
    yield Way("scipy", "expert: sosfilt in windows, decimating taps", each(by_scipy, 1e-10), "equal", f"{CUT} to 1e-10")
    if compiled is not None:
        yield Way("numba", "expert: lanes of windows", each(compiled, 1e-13), "equal", f"{CUT} to 1e-13")


def _sections_of_peers(rows: np.ndarray, iir: Any) -> Iterator[Way]:
    """The filter ``iir`` over rows (r, n) by the libraries that wrap one; they design it from its edges."""
    edges = _design_edges(iir)
    if mne := peer("mne"):
        design = {"sos": iir.sos, "output": "sos"}

        def by_mne() -> np.ndarray:
            return mne.filter.filter_data(
                rows,
                FS_HZ,
                1.0,
                None,
                method="iir",
                iir_params=mne.filter.construct_iir_filter(
                    design, None, None, FS_HZ, "highpass", return_copy=True, verbose="error"
                ),
                phase="zero",
                verbose="error",
            )

        yield Way(
            "MNE", "filter_data, iir", by_mne, "equal", "pads the ends otherwise, which is its error on whole records"
        )
    if neurokit := peer("neurokit2"):

        def by_neurokit() -> np.ndarray:
            low, high = edges if len(edges) == 2 else (None, edges[0])
            return np.array(
                [
                    neurokit.signal_filter(row, FS_HZ, lowcut=low, highcut=high, method="butterworth", order=2)
                    for row in rows
                ]
            )

        yield Way("NeuroKit2", "signal_filter, loop", by_neurokit, "equal")


def _design_edges(iir: Any) -> list[float]:
    """Edges (Hz) of one pass, to give to a library that designs its own filter."""
    from emg2vsa.settings import FilterSettings
    from emg2vsa.signals.filters import one_pass_band_hz

    filters = FilterSettings()
    if not iir.passes_offset:
        return list(one_pass_band_hz(filters.band_hz, filters.band_order, filters.phase, FS_HZ))
    # a low-pass of two passes is 3 dB down where one pass is 1.5 dB down (Winter 2009, 2.2.4.4)
    widening = (2**0.5 - 1) ** (1 / (2 * filters.force_order))
    edge = np.arctan(np.tan(np.pi * filters.force_cutoff_hz / FS_HZ) / widening) * FS_HZ / np.pi
    return [float(edge)]


def _recipes() -> Iterator[tuple[str, str, Callable[[np.ndarray], np.ndarray]]]:
    """Library, what is called, and the envelope of one row (n,)."""
    if mne := peer("mne"):

        def by_mne(row: np.ndarray) -> np.ndarray:
            filtered = mne.filter.filter_data(row, FS_HZ, 10, 450, method="iir", verbose="error")
            return np.asarray(mne.filter.filter_data(np.abs(filtered), FS_HZ, None, 20, method="fir", verbose="error"))

        yield "MNE", "filter_data iir, abs, filter_data fir", by_mne
    if neurokit := peer("neurokit2"):

        def by_neurokit(row: np.ndarray) -> np.ndarray:
            return np.asarray(neurokit.emg_amplitude(neurokit.emg_clean(row, sampling_rate=int(FS_HZ))))

        yield "NeuroKit2", "emg_clean, emg_amplitude", by_neurokit


def _scipy_whole(rows: np.ndarray, filters: Any) -> np.ndarray:
    from emg2vsa.signals.envelope import smoother
    from emg2vsa.signals.filters import band_pass

    band, kernel = band_pass(filters, FS_HZ), smoother(filters, FS_HZ, STEP)
    rectified = np.abs(signal.sosfiltfilt(band.sos, rows))
    return np.asarray(signal.oaconvolve(rectified, kernel.taps[None], mode="same", axes=-1))


def _instants(records: Records) -> np.ndarray:
    """Samples of the envelope, counted from the start of a trial."""
    return int(records.first[0]) + STEP * np.arange(int(records.counts[0]))


def _forward_backward(row: np.ndarray, sos: np.ndarray, pad: int) -> np.ndarray:
    """Both passes over (n,) in 80-bit arithmetic, odd extension of ``pad`` samples, steady state at the start."""
    x = row.astype(np.longdouble)
    x = np.concatenate((2 * x[0] - x[pad:0:-1], x, 2 * x[-1] - x[-2 : -pad - 2 : -1]))
    sections = sos.astype(np.longdouble)
    for _ in range(2):
        x = signal.sosfilt(sections, x, zi=_steady_state(sections) * x[0])[0][::-1]
    return x[pad:-pad]


def _steady_state(sections: np.ndarray) -> np.ndarray:
    """State (sections, 2) of every section, transposed direct form II, after a constant 1 for ever."""
    states, level = [], sections.dtype.type(1)
    for b0, b1, b2, _, a1, a2 in sections:
        out = level * (b0 + b1 + b2) / (1 + a1 + a2)
        states.append((out - b0 * level, b2 * level - a2 * out))
        level = out
    return np.array(states)


@cache
def _exact_of(n_trials: int, filters: Any) -> np.ndarray:
    from emg2vsa.signals.envelope import smoother
    from emg2vsa.signals.filters import band_pass

    band, kernel = band_pass(filters, FS_HZ), smoother(filters, FS_HZ, STEP)
    records = records_of(n_trials)
    at = records.first[:, None] + STEP * np.arange(int(records.counts[0]))
    taps = kernel.taps.astype(np.longdouble)
    found = []
    for row in records.emg[0]:
        filtered = _forward_backward(row, band.sos, band.pad_samples)
        rectified = filtered**2 if kernel.squared else np.abs(filtered)
        smooth = rectified[at[:, :, None] + np.arange(-kernel.before, kernel.after + 1)] @ taps
        found.append(np.sqrt(smooth) if kernel.squared else smooth)
    return np.array(found).swapaxes(0, 1)


def _exact(records: Records, filters: Any) -> np.ndarray:
    """(10, muscles, instants) of the first record."""
    return np.asarray(_exact_of(len(records.emg) * PER_RECORD, filters))


def _relative(found: np.ndarray, truth: np.ndarray) -> float:
    return float(np.max(np.abs(found - truth)) / np.max(np.abs(truth)))


def _level_error(found: np.ndarray, level_v: np.ndarray) -> float:
    """RMS error of envelopes (r, instants) of the level (instants,), after one factor for all: filters differ in the
    power that they let pass."""
    scaled = found * (level_v.mean() / found.mean())
    return float(np.sqrt(np.mean((scaled / level_v - 1) ** 2)))


AREA = Area(
    name="conditioning",
    question="What does conditioning EMG and force cost, and how exact is it, beside libraries that filter signals?",
    parts=(emg_in_windows, whole_records, as_people_use_them),
    peers={"mne": "mne", "neurokit2": "neurokit2"},
    meaning=(
        "In the force windows all ways give one output, so their ratios are of speed alone; the row over whole records "
        "shows what is saved by not filtering what no window needs. In the last table every library follows its own "
        "recipe: the error there is mostly that of the smoother (a longer one scatters less and follows a ramp later), "
        "and that of rounding does not show."
    ),
)
