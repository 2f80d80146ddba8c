"""Filters do what they say: edges, delays, memory, and the Nyquist rule aloud.

Amplitude and phase of sines in pieces equal the sum that defines them.

Products in parts: equal to the product at once, whatever the sizes, and never shared among threads.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import signal

from emg2vsa.errors import SettingError
from emg2vsa.settings import FilterSettings
from emg2vsa.signals import products
from emg2vsa.signals.filters import band_pass, default_pad_samples, force_low_pass, gain, group_delay_samples
from emg2vsa.signals.hum import BLOCK, sine_phasors
from emg2vsa.signals.products import times
from emg2vsa.signals.windowed import filter_record


@pytest.mark.parametrize("phase", ["causal", "compensated"])
def test_one_pass_is_3_db_down_at_the_edges_asked_for(phase):
    assert "true -3 dB at 10 Hz and 450 Hz" in band_pass(FilterSettings(phase=phase), 1000.0).notes[-1]


@pytest.mark.parametrize("order", [1, 2, 4])
def test_two_passes_are_3_db_down_at_the_edges_asked_for(order):
    band = band_pass(FilterSettings(band_order=order), 1000.0)
    low = force_low_pass(FilterSettings(force_order=order), 1000.0)
    high = band_pass(FilterSettings(band_order=order, band_hz=(10.0, 500.0)), 1000.0)
    for sos, edge in ((band.sos, 10.0), (band.sos, 450.0), (low.sos, 5.0), (high.sos, 10.0)):
        _, response = signal.freqz_sos(sos, [edge], fs=1000.0)
        assert abs(response[0]) ** 4 == pytest.approx(0.5, rel=1e-9)
    assert "true -3 dB at 10 Hz and 450 Hz" in band.notes[-1]
    plain = signal.butter(order, (10.0, 450.0), "bandpass", fs=1000.0, output="sos")
    assert gain(plain, 10.0, 1000.0) ** 4 == pytest.approx(0.25, rel=1e-6)  # 6 dB down: what is avoided


@pytest.mark.parametrize("upper", [500.0, 501.0, 5000.0])
def test_nyquist_rule_drops_the_upper_edge_and_says_so_first(upper):
    band = band_pass(FilterSettings(band_hz=(10.0, upper), phase="causal"), 1000.0)
    assert np.array_equal(band.sos, signal.butter(2, 10.0, "highpass", fs=1000.0, output="sos"))
    assert band.notes[0].startswith("NYQUIST RULE")
    assert f"{upper:g} Hz" in band.notes[0]
    assert "true -3 dB at 10 Hz;" in band.notes[-1]


def test_an_upper_edge_just_below_half_the_rate_is_built():
    band = band_pass(FilterSettings(band_hz=(10.0, 499.0)), 1000.0)
    assert band.name == "EMG band-pass"
    assert not any("NYQUIST" in note for note in band.notes)


@pytest.mark.parametrize("band_hz", [(500.0, 600.0), (450.0, 10.0), (10.0, 10.0)])
def test_a_band_that_cannot_be_is_refused(band_hz):
    with pytest.raises(SettingError, match=r"filters\.band_hz"):
        band_pass(FilterSettings(band_hz=band_hz), 1000.0)


def test_force_filter_off_or_too_high():
    assert force_low_pass(FilterSettings(force_filter=False), 100.0) is None
    with pytest.raises(SettingError, match="force_cutoff_hz"):
        force_low_pass(FilterSettings(force_cutoff_hz=50.0), 100.0)


@pytest.mark.parametrize(("order", "fs_hz"), [(1, 200.0), (2, 1000.0), (4, 2048.0)])
def test_force_delay_is_that_of_the_butterworth(order, fs_hz):
    low = force_low_pass(FilterSettings(phase="causal", force_order=order), fs_hz)
    # delay at 0 Hz of a Butterworth prototype: the sum of Re(-1/pole) over its poles on the unit circle
    poles = np.exp(1j * np.pi * (2 * np.arange(order) + order + 1) / (2 * order))
    expected_s = float(np.sum((-1 / poles).real)) / (2 * fs_hz * math.tan(math.pi * 5 / fs_hz))
    assert low.delay_s == pytest.approx(expected_s, rel=1e-9)


def test_group_delay_agrees_with_scipy():
    sos = signal.butter(3, (20.0, 300.0), "bandpass", fs=1000.0, output="sos")
    b, a = signal.butter(3, (20.0, 300.0), "bandpass", fs=1000.0)
    _, expected = signal.group_delay((b, a), w=[40.0, 77.0, 200.0], fs=1000.0)
    assert [group_delay_samples(sos, f, 1000.0) for f in (40.0, 77.0, 200.0)] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("order", [1, 2, 3, 5])
def test_padding_is_that_of_sosfiltfilt(order):
    sos = signal.butter(order, (10.0, 450.0), "bandpass", fs=1000.0, output="sos")
    pad = default_pad_samples(sos)
    signal.sosfiltfilt(sos, np.ones(pad + 1))
    with pytest.raises(ValueError, match="padlen"):
        signal.sosfiltfilt(sos, np.ones(pad))


def by_longdouble(sos, samples):
    """One pass that starts in the steady state of the first sample, in extended precision."""
    x = samples.astype(np.longdouble)
    for section in sos:
        b0, b1, b2, _, a1, a2 = (np.longdouble(c) for c in section)
        # what the section settles at: its gain at 0 Hz is that of the exact design, 1 or 0
        settled = x[0] * (b0 + b1 + b2) / (1 + a1 + a2)
        s1, s2 = settled - b0 * x[0], b2 * x[0] - a2 * settled
        y = np.empty_like(x)
        for i, value in enumerate(x):
            y[i] = b0 * value + s1
            s1, s2 = b1 * value - a1 * y[i] + s2, b2 * value - a2 * y[i]
        x = y
    return x


@pytest.mark.parametrize(
    ("kind", "edge", "fs_hz", "offset"),
    [("low", 5.0, 1000.0, 1e6), ("low", 5.0, 20_000.0, 1e6), ("low", 0.5, 1000.0, 1e6), ("band", 20.0, 1000.0, 1e6)],
)
def test_an_offset_costs_no_digits(kind, edge, fs_hz, offset):
    if kind == "low":
        made = force_low_pass(FilterSettings(force_cutoff_hz=edge, phase="causal"), fs_hz)
    else:
        made = band_pass(FilterSettings(band_hz=(edge, 450.0), phase="causal"), fs_hz)
    wave = np.round(np.random.default_rng(0).standard_normal(4000) * 2**20) / 2**20
    wave -= wave[0]
    got = filter_record(wave + offset, made) - (offset if kind == "low" else 0.0)
    truth = by_longdouble(made.sos, wave)
    error = np.max(np.abs(got - truth)) / np.max(np.abs(truth))
    # of the sum with the offset float64 keeps 1e-16 of 1e6 times the signal; the filter itself adds nothing to that
    assert error < 1e-9 * (1e-3 if kind == "band" else 1.0) * max(1.0, 1 / np.max(np.abs(truth)))


@pytest.mark.parametrize(
    ("build", "settings", "key"),
    [
        (force_low_pass, FilterSettings(force_cutoff_hz=0.01), "filters.force_cutoff_hz"),
        (band_pass, FilterSettings(band_hz=(0.01, 50.0)), "filters.band_hz"),
    ],
)
def test_a_filter_that_would_lose_its_digits_is_refused_with_those_it_would_keep(build, settings, key):
    with pytest.raises(SettingError, match=rf"(?s){key}.*7 digits.*found one that keeps [34]\.\d"):
        build(settings, 20_000.0)


def test_practical_filters_are_built():
    for fs_hz in (200.0, 1000.0, 20_000.0):
        assert force_low_pass(FilterSettings(), fs_hz) is not None
    assert band_pass(FilterSettings(), 50_000.0) is not None
    assert force_low_pass(FilterSettings(force_cutoff_hz=0.05), 1000.0) is not None


FS_HZ = 1000.0


def plainly(samples: np.ndarray, begin: int, end: int, hz: np.ndarray) -> np.ndarray:
    """Phasors (h,) by a sum over every sample of the piece."""
    size = end - begin
    window = np.array([np.sin(np.pi * (i + 0.5) / size) ** 2 for i in range(size)])
    turning = np.exp(-2j * np.pi / FS_HZ * np.outer(np.arange(size), hz))
    return 2 / window.sum() * (window * samples[begin:end]) @ turning


@pytest.mark.parametrize(
    "pieces", [[(0, 500)], [(7, 8)], [(0, BLOCK), (1, BLOCK), (5, 6 + BLOCK)], [(3, 2003), (9, 99)]]
)
def test_equal_to_the_sum_over_samples(pieces):
    channels = np.random.default_rng(0).standard_normal((2, 2010))
    hz = np.array([0.0, 49.93, 250.5, 499.9])
    got = sine_phasors(tuple(channels), pieces, hz, FS_HZ)
    assert got.shape == (2, len(pieces), hz.size)
    for m, row in enumerate(channels):
        for i, piece in enumerate(pieces):
            np.testing.assert_allclose(got[m, i], plainly(row, *piece, hz), rtol=0, atol=1e-13)


def test_a_sine_shows_its_amplitude_and_its_phase_at_the_first_sample():
    at = np.arange(5000) / FS_HZ
    wave = 3.0 * np.cos(2 * np.pi * 50.2 * at + 0.7)
    ((found,),) = sine_phasors((wave,), [(1000, 3000)], np.array([50.2]), FS_HZ)
    assert abs(found[0]) == pytest.approx(3.0, rel=1e-4)
    assert np.angle(found[0] * np.exp(-2j * np.pi * 50.2)) == pytest.approx(0.7, abs=1e-4)


def test_no_pieces_and_no_sines():
    wave = np.ones(100)
    assert sine_phasors((wave,), [], np.array([50.0]), FS_HZ).shape == (1, 0, 1)
    assert sine_phasors((wave,), [(0, 50)], np.empty(0), FS_HZ).shape == (1, 1, 0)


SIZES = [
    (1, 1, 1, 1), (2, 0, 5, 3), (2, 3, 5, 0), (1, 51, 80, 64), (2, 48, 80, 64), (3, 97, 80, 64), (2, 5000, 64, 8),
    (1, 6000, 4, 4), (1, 40, 300, 200), (1, 3, 9000, 7), (2, 20, 5000, 1), (1, 1, 4096, 3), (1, 2, 4097, 2),
]  # fmt: skip


@pytest.mark.parametrize(("m", "n", "p", "q"), SIZES)
def test_it_is_the_product(m: int, n: int, p: int, q: int) -> None:
    rng = np.random.default_rng(n)
    rows, matrix = rng.standard_normal((m, n + 1, p + 3))[:, 1:, :p], rng.standard_normal((p, q))
    expected = np.einsum("mnp,pq->mnq", rows.astype(np.longdouble), matrix.astype(np.longdouble))
    size = np.einsum("mnp,pq->mnq", np.abs(rows), np.abs(matrix))
    assert (np.abs(times(rows, matrix) - expected) <= 1e-15 * np.sqrt(p) * size + 1e-300).all()


@pytest.mark.parametrize(("m", "n", "p", "q"), SIZES)
def test_no_part_is_large_enough_to_be_shared(monkeypatch: pytest.MonkeyPatch, m: int, n: int, p: int, q: int) -> None:
    asked: list[tuple[int, int, int]] = []
    plain = np.matmul

    def watched(left: np.ndarray, right: np.ndarray, out: np.ndarray) -> np.ndarray:
        asked.append((left.shape[-2], *right.shape))
        return plain(left, right, out=out)

    monkeypatch.setattr(products.np, "matmul", watched)
    times(np.ones((m, n, p)), np.ones((p, q)))
    for rows, long, wide in asked:
        assert rows * long * wide <= 65_536 * 4
        assert long * wide <= 2304 * 4
        assert long <= 10_000
        assert wide > 1 or rows * long <= 2304 * 4
