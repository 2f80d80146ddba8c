"""Windows are filtered as the whole record would be, wherever they stand in it."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import Literal

import numpy as np
import pytest
from scipy import signal

from emg2vsa.errors import SignalError
from emg2vsa.settings import FilterSettings
from emg2vsa.signals.envelope import envelopes_at, smoother
from emg2vsa.signals.filters import band_pass, force_low_pass
from emg2vsa.signals.windowed import filter_record, filter_windows

FS_HZ = 1000.0
N = 12_000
DOUBLE_POLES_HZ = [
    1e4 / np.pi * np.arctan((1 + 2**0.5) ** 2 * np.tan(np.pi * 0.01)) * (1 + apart) for apart in (-1e-9, 0.0, 1e-9)
]
"Upper edges (Hz), at 10 kHz, of a band-pass of order 1 from 100 Hz on."


def record(seed: int = 0, n: int = N) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal((2, n))


@pytest.mark.parametrize("phase", ["zero-phase", "causal"])
@pytest.mark.parametrize("n", [0, 1, 2, 5, 15, 16, 30])
def test_a_record_is_filtered_or_refused_however_short(n: int, phase: Literal["zero-phase", "causal"]) -> None:
    """As SciPy's sosfiltfilt, which asks for more samples than it extends the record by."""
    band, samples = band_pass(FilterSettings(phase=phase), FS_HZ), record(n=n)[0]
    if n > band.pad_samples:
        assert np.isfinite(filter_record(samples, band)).all()
        return
    wanted = rf"EMG band-pass: expected more than {band.pad_samples} samples, but found {n}\. Record for longer\."
    with pytest.raises(SignalError, match=wanted):
        filter_record(samples, band)
    with pytest.raises(SignalError, match=wanted):
        filter_windows((samples,), np.array([0]), np.array([n]), band)


@pytest.mark.parametrize("odd", [np.inf, -np.inf, np.nan])
@pytest.mark.parametrize("at", [0, 700, -1])
def test_a_record_with_a_value_that_is_not_finite_is_refused(odd: float, at: int) -> None:
    samples = record(n=900)[0]
    samples[at] = odd
    with pytest.raises(SignalError, match=r"EMG band-pass: expected finite samples, but found 1 of 900 that are not\."):
        filter_record(samples, band_pass(FilterSettings(), FS_HZ))


WINDOWS = [
    pytest.param([0], [900], id="at the start"),
    pytest.param([N - 900], [N], id="at the end"),
    pytest.param([4000], [4001], id="one sample"),
    pytest.param([3000, 5500, 9000], [3800, 6000, 9001], id="some apart, of other lengths"),
    pytest.param([3000, 3100, 3050], [3500, 4200, 3060], id="overlapping, in no order"),
    pytest.param([0, 5000, N - 1], [1, 5700, N], id="both ends and between"),
    pytest.param([0], [N], id="the whole record"),
]


@pytest.mark.parametrize("phase", ["zero-phase", "causal"])
@pytest.mark.parametrize(("starts", "stops"), WINDOWS)
def test_windows_equal_the_filtered_record(starts, stops, phase):
    channels, band = record(), band_pass(FilterSettings(phase=phase), FS_HZ)
    got = filter_windows(tuple(channels), np.array(starts), np.array(stops), band)
    whole = np.stack([filter_record(row, band) for row in channels])
    assert len(got) == len(starts)
    for window, start, stop in zip(got, starts, stops, strict=True):
        assert window.shape == (2, stop - start)
        np.testing.assert_allclose(window, whole[:, start:stop], rtol=0, atol=1e-12 * np.abs(whole).max())


@pytest.mark.parametrize("order", [1, 2, 4])
@pytest.mark.parametrize("upper_hz", [450.0, 500.0])
def test_windows_equal_sosfiltfilt_at_every_order(order, upper_hz):
    channels, band = record(1), band_pass(FilterSettings(band_order=order, band_hz=(20.0, upper_hz)), FS_HZ)
    (got,) = filter_windows(tuple(channels), np.array([5000]), np.array([5800]), band)
    expected = signal.sosfiltfilt(band.sos, channels)[:, 5000:5800]
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-11 * np.abs(expected).max())


@pytest.mark.parametrize(
    "settings",
    [
        FilterSettings(band_hz=(20.0, 5000.0)),
        FilterSettings(band_hz=(5.0, 450.0), band_order=8),
        FilterSettings(band_hz=(99.0, 101.0), band_order=4),
        # the poles of this order meet where the upper edge is (1 + sqrt 2)^2 times the lower, warped
        *(FilterSettings(band_hz=(100.0, upper_hz), band_order=1, phase="causal") for upper_hz in DOUBLE_POLES_HZ),
        FilterSettings(band_hz=(100.0, 571.0), band_order=3),
    ],
    ids=lambda settings: f"{settings.band_hz[0]:g}-{settings.band_hz[1]:.9g} Hz, order {settings.band_order}",
)
def test_windows_of_any_filter_equal_its_sections_run_from_sample_to_sample(settings):
    fs_hz = 10_000.0
    band = band_pass(settings, fs_hz)
    channels = record(6, 2 * band.support_samples + 3000)
    start = np.array([band.support_samples + 1000])
    (got,) = filter_windows(tuple(channels), start, start + 900, band)
    run = signal.sosfiltfilt if band.zero_phase else signal.sosfilt
    expected = run(band.sos, channels.astype(np.longdouble))[:, start[0] : start[0] + 900]
    np.testing.assert_allclose(got, expected.astype(np.float64), rtol=0, atol=1e-11 * np.abs(expected).max())


@pytest.mark.parametrize("offset", [0.0, 1e3, 1e6])
def test_an_offset_costs_windows_no_more_than_its_own_rounding(offset):
    channels = record(2)
    rounding = 4e-16 * max(offset, 1.0)
    for iir, gain in ((band_pass(FilterSettings(), FS_HZ), 0.0), (force_low_pass(FilterSettings(), FS_HZ), 1.0)):
        (with_offset,) = filter_windows(tuple(channels + offset), np.array([5000]), np.array([5800]), iir)
        (without,) = filter_windows(tuple(channels), np.array([5000]), np.array([5800]), iir)
        np.testing.assert_allclose(with_offset - gain * offset, without, rtol=0, atol=1e-12 + 10 * rounding)


@pytest.mark.parametrize("kind", ["band", "low"])
def test_a_baseline_a_thousand_times_larger_costs_no_more_digits_than_in_the_whole_record(kind):
    """Against the impulse response in extended precision."""
    iir = band_pass(FilterSettings(), FS_HZ) if kind == "band" else force_low_pass(FilterSettings(), FS_HZ)
    rng = np.random.default_rng(5)
    samples = rng.standard_normal(20_000) + 1e3 * np.cumsum(rng.standard_normal(20_000)) / 30
    impulse = signal.sosfiltfilt(iir.sos, np.eye(1, 8001, 4000)[0], padlen=0).astype(np.longdouble)
    (got,) = filter_windows((samples,), np.array([8000]), np.array([10_000]), iir)
    whole = filter_record(samples, iir)[8000:10_000]
    at = np.arange(0, 2000, 40)
    truth = np.array([impulse @ samples[4000 + i : 12_001 + i].astype(np.longdouble) for i in at], dtype=np.float64)
    allowed = max(4 * np.abs(whole[at] - truth).max(), 1e-14 * np.abs(samples).max())
    assert np.abs(got[0, at] - truth).max() < allowed


def test_single_precision_and_a_strided_channel_are_filtered_in_double():
    channels, band = record(3).astype(np.float32), band_pass(FilterSettings(), FS_HZ)
    start, stop = np.array([5000]), np.array([5400])
    (got,) = filter_windows((channels[0], channels[1]), start, stop, band)
    (double,) = filter_windows(tuple(channels.astype(np.float64)), start, stop, band)
    (strided,) = filter_windows(tuple(np.asfortranarray(channels.astype(np.float64))), start, stop, band)
    np.testing.assert_allclose(got, double, rtol=0, atol=1e-6)
    assert np.array_equal(strided, double)


@pytest.mark.parametrize(
    "settings",
    [
        FilterSettings(),
        FilterSettings(envelope="rms"),
        FilterSettings(envelope="rms", output_fs_hz="native"),
        FilterSettings(fir_order=200, output_fs_hz=10.0),
        FilterSettings(fir_order=4, output_fs_hz=10.0),
        FilterSettings(phase="causal"),
    ],
    ids=["default", "rms", "rms at its own rate", "long", "shorter than a step", "causal"],
)
def test_envelopes_equal_a_plain_weighted_sum_at_each_instant(settings):
    step = 1 if settings.output_fs_hz == "native" else round(FS_HZ / settings.output_fs_hz)
    channels, band, kernel = record(4), band_pass(settings, FS_HZ), smoother(settings, FS_HZ, step)
    first, counts = np.array([0, 4000, 7000, N - 1 - 40 * step]), np.array([30, 1, 0, 41])
    got = envelopes_at(tuple(channels), first, counts, step, band, kernel)
    filtered = np.stack([filter_record(row, band) for row in channels])
    level = filtered**2 if kernel.squared else np.abs(filtered)
    expected = []
    for at in np.concatenate([a + step * np.arange(k) for a, k in zip(first, counts, strict=True)]):
        under = np.arange(at - kernel.before, at + kernel.after + 1)
        taps, inside = kernel.taps, (under >= 0) & (under < N)
        total = max(taps[inside].sum(), 0.5 * taps.sum())
        value = np.maximum(level[:, under[inside]] @ taps[inside] / total, 0.0)
        expected.append(np.sqrt(value) if kernel.squared else value)
    np.testing.assert_allclose(got, np.array(expected).T, rtol=0, atol=2e-12 * np.max(expected))


def test_a_window_whose_support_ends_just_beyond_either_end_of_the_record():
    """The support of such a window begins, or ends, within the odd extension of the record."""
    channels = record(4, 4000)
    for iir in (band_pass(FilterSettings(), FS_HZ), force_low_pass(FilterSettings(), FS_HZ)):
        whole = np.stack([filter_record(row, iir) for row in channels])
        support = iir.support_samples
        for beyond in (-2, -1, 0, 1, 2, 7, iir.pad_samples - 1, iir.pad_samples, iir.pad_samples + 1):
            for start, stop in (
                (support - beyond, support - beyond + 40),
                (3960 - support + beyond, 4000 - support + beyond),
            ):
                start, stop = max(start, 0), min(stop, 4000)
                (got,) = filter_windows(tuple(channels), np.array([start]), np.array([stop]), iir)
                np.testing.assert_allclose(got, whole[:, start:stop], rtol=0, atol=2e-10 * np.abs(whole).max())


MANY_CORES = """
import hashlib, sys
import numpy as np
from emg2vsa.settings import FilterSettings
from emg2vsa.signals.envelope import envelopes_at, smoother
from emg2vsa.signals.filters import band_pass, force_low_pass
from emg2vsa.signals.windowed import filter_record, filter_windows

record = np.random.default_rng(3).standard_normal((2, 300_000))
told = hashlib.sha256()
for iir in (band_pass(FilterSettings(band_order=4), 2000.0), force_low_pass(FilterSettings(), 2000.0)):
    told.update(filter_record(record[0], iir).tobytes())
    starts = np.arange(1000, 280_000, 9000)
    for window in filter_windows(tuple(record), starts, starts + 5000, iir):
        told.update(window.tobytes())
for step, filters in ((1, FilterSettings(fir_order=500)), (20, FilterSettings(envelope="rms"))):
    band, kernel = band_pass(filters, 2000.0), smoother(filters, 2000.0, step)
    told.update(envelopes_at(tuple(record), starts, np.full(31, 4000 // step), step, band, kernel).tobytes())
print(told.hexdigest())
"""


def test_the_same_bytes_on_any_number_of_cores() -> None:
    """With the kernels of OpenBLAS that round otherwise where threads share a product."""
    told = {
        subprocess.run(
            [sys.executable, "-c", MANY_CORES],
            env=os.environ | {"OPENBLAS_CORETYPE": "Haswell", "OPENBLAS_NUM_THREADS": threads},
            check=True,
            capture_output=True,
        ).stdout
        for threads in ("1", "2")
    }
    assert len(told) == 1
