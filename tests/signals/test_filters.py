"""Filters do what they say: edges, delays, memory, and the Nyquist rule aloud."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import signal

from emg2vsa.errors import SettingError
from emg2vsa.settings import FilterSettings
from emg2vsa.signals.filters import band_pass, default_pad_samples, force_low_pass, gain, group_delay_samples
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
