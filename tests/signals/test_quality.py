"""Measures of quality, each provoked and each silent on a clean signal.

Mishaps of a laboratory: each is told by its cause with a remedy, and nothing is said of a clean session.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.mishaps import MISHAPS, clean_record, judged
from benchmarks.verdict_thresholds import BASE, analysed
from emg2vsa.signals.plausibility import force_unit_doubt
from emg2vsa.signals.quality import falling_share, mains_ratios, ratio_db, raw_qualities, window_means

FS_HZ = 1000.0
CLEAN = np.random.default_rng(0).standard_normal(2500)


def quality(samples, missing=None):
    return raw_qualities([samples], [np.zeros(samples.size, bool) if missing is None else missing], FS_HZ)[0]


def test_a_clean_signal():
    found = quality(CLEAN)
    assert (found.clip_share, found.repeat_share, found.held_samples, found.flat, found.missing) == (0, 0, 1, False, 0)
    assert found.mains_ratio < 0.02


def test_clipping_counts_runs_at_the_extremes_only():
    clipped = np.clip(np.repeat(CLEAN, 1), -1.5, 1.5)
    at = np.abs(clipped) == 1.5
    inner = at & (np.r_[False, clipped[1:] == clipped[:-1]] | np.r_[clipped[1:] == clipped[:-1], False])
    assert quality(clipped).clip_share == pytest.approx(inner.mean())
    held = CLEAN.copy()
    held[100:140] = 0.3
    assert quality(held).clip_share == 0
    assert quality(held).held_samples == 40


def test_two_equal_samples_at_a_peak_do_not_clip():
    """Real EMG of 100 uV in steps of 0.15 uV, in presses of half a second, was rejected for two equal samples."""
    peak = CLEAN[:500].copy()
    top, bottom = np.argmax(peak), np.argmin(peak)
    peak[top + 1], peak[bottom + 1] = peak[top], peak[bottom]
    assert quality(peak).clip_share == 0
    peak[top - 1] = peak[top]
    assert quality(peak).clip_share == pytest.approx(5 / 500)


def test_a_coarse_converter_does_not_clip():
    coarse = np.round(CLEAN * 20)
    assert quality(coarse).clip_share < 0.001


def test_flat_and_repeated():
    assert quality(np.full(100, 2.0)).flat
    assert quality(np.repeat(CLEAN, 2)).repeat_share == pytest.approx(0.5, abs=0.001)


@pytest.mark.parametrize("mains_hz", [49.95, 50.0, 60.0, 60.05])
def test_mains_power_is_measured(mains_hz):
    hum = np.sqrt(2) * np.sin(2 * np.pi * mains_hz * np.arange(2500) / FS_HZ + 1)
    hummed = CLEAN + hum + 100
    windows = [hummed, hummed[:50], hummed[100:], CLEAN, hummed[:700]]
    half = pytest.approx(0.5, abs=0.04)
    assert mains_ratios(windows, FS_HZ).tolist() == [half, 0, half, pytest.approx(0, abs=0.02), half]


def test_missing_samples_are_counted():
    assert quality(CLEAN, np.arange(CLEAN.size) < 3).missing == 3


def test_falling_share_of_a_known_path():
    up_down_up = np.concatenate([np.linspace(0, 3, 50), np.linspace(3, 2, 50), np.linspace(2, 7, 50)])
    assert falling_share(up_down_up, 0.1) == pytest.approx(1 / 9)
    assert falling_share(up_down_up, 1.1) == 0
    assert falling_share(np.linspace(0, 7, 100), 0.0) == 0
    assert falling_share(-np.linspace(0, 7, 100), 0.1) == 1
    assert falling_share(np.array([1.0]), 0.1) == 0


@given(st.lists(st.integers(-50, 50), min_size=2, max_size=40), st.integers(-100, 100), st.integers(1, 9))
def test_falling_share_ignores_offset_and_scale_and_mirrors(levels, offset, scale):
    force = np.array(levels, dtype=float)
    share = falling_share(force, 0.0)
    assert falling_share(scale * force + offset, 0.0) == pytest.approx(share)
    steps = np.diff(force)
    path = np.abs(steps).sum()
    assert share == pytest.approx(-steps[steps < 0].sum() / path if path else 0)


def test_ratio_and_means():
    assert ratio_db(np.array([10.0]), np.array([1.0])) == pytest.approx([20.0])
    assert np.isnan(ratio_db(np.array([1.0]), np.array([np.nan])))
    means = window_means(np.array([[1.0, 3.0, 5.0]]), np.array([0, 2, 2, 3]))
    assert means[0, [0, 2]] == pytest.approx([2.0, 5.0])
    assert np.isnan(means[0, 1])


UNHARMED = ("nothing", "drift 2 N over the record")
SAMPLE = (
    "EMG in uV labelled V", "EMG in V labelled mV", "one channel exported twice", "crosstalk 30 %",
    "contact fades to 0.2", "electrode off: slow wander", "clipping, 0.2 uV noise on the rails",
    "ECG of 150 uV",
    "ECG of 60 uV, 160 a minute",
    "EMG rectified already", "EMG an RMS over 100 ms already", "lbf labelled N", "record begins in the first press",
    "EMG exported at 200 Hz", "packets of 27 samples sent twice", "force 200 ms late", "drying electrodes, to 0.4",
    "force interpolated from 5 Hz", "force held from 10 Hz", "force AC-coupled at 0.3 Hz", "force and FDS exchanged",
    "converter of 20 uV a step", "readings of force glued",
)  # fmt: skip


@pytest.mark.parametrize("name", SAMPLE)
def test_a_mishap_is_told_by_its_cause(name):
    spoil, cause = MISHAPS[name]
    record = clean_record(11)
    spoil(record)
    found = judged(record)
    assert found.word != "good"
    assert cause
    assert re.search(cause, found.cause)
    assert found.remedy or "Export the recording again" in found.cause


@pytest.mark.parametrize("name", ["artefact at contact, 150 uV", "artefact at contact, 500 uV"])
def test_an_artefact_at_contact_is_left_out_and_told(name: str):
    clean, record = clean_record(11), clean_record(11)
    MISHAPS[name][0](record)
    found = judged(record)
    assert "left out" in found.cause
    assert found.remedy
    assert found.word == "good"
    assert found.b_v == pytest.approx(judged(clean).b_v, rel=0.06)


@pytest.mark.parametrize("name", ["0.1 % spikes of 5 mV", "a 100 ms burst in one press"])
def test_what_is_mended_is_told_by_its_cause(name: str):
    clean, record = clean_record(11), clean_record(11)
    spoil, cause = MISHAPS[name]
    spoil(record)
    found = judged(record)
    assert re.search(cause, found.cause)
    assert found.remedy
    assert found.word == "good"
    assert found.b_v == pytest.approx(judged(clean).b_v, rel=0.02)


@pytest.mark.parametrize("name", UNHARMED)
def test_nothing_is_said_where_nothing_is_wrong(name):
    record = clean_record(12)
    MISHAPS[name][0](record)
    found = judged(record)
    assert (found.word, found.cause) == ("good", "")


@pytest.mark.parametrize("carrier", ["20/45", "laplacian", "units-6"])
def test_no_alarm_over_an_unusual_muscle(carrier):
    from dataclasses import replace

    found = analysed(replace(BASE, carrier=carrier, presses=6), 3)
    assert found.trials.remarks == ()
    assert found.trials.fault == ""
    assert found.fits.verdict.tolist() == ["ok"] * 6


@pytest.mark.parametrize("name", [name for name in MISHAPS if name.startswith("baseline")])
def test_a_baseline_is_told_and_changes_nothing(name):
    clean, record = judged(clean_record(13)), clean_record(13)
    MISHAPS[name][0](record)
    found = judged(record)
    assert found.word == "usable"
    assert found.verdict.ok == clean.verdict.ok == 8
    assert [" ".join(line.split()[:4]) for line in found.verdict.problems] == [
        "the baseline of EDC", "the baseline of FDS",
    ]  # fmt: skip
    assert found.b_v == pytest.approx(clean.b_v, rel=0.01)


@pytest.mark.parametrize("size", [50, 100, 200])
def test_an_envelope_is_no_baseline(size):
    record = clean_record(14)
    for muscle, x in record.emg_v.items():
        record.emg_v[muscle] = np.convolve(np.abs(x), np.full(size, 1 / size), mode="same")
    assert "is it an envelope" in judged(record).verdict.fault


def test_units_of_force():
    wave = np.sin(np.linspace(0, np.pi, 100))
    for peak_n, unit in ((7.5 / 4.448, "lbf"), (7.5 / 9.81, "kgf"), (765.0, "gf"), (7500.0, "mN"), (7.5e-3, "kN")):
        assert f"is its unit {unit} " in force_unit_doubt(peak_n * wave, (0.5, 7.0))
    for peak_n in (7.2, 9.0, 5.6, 3.0, 100.0, 0.2):
        assert force_unit_doubt(peak_n * wave, (0.5, 7.0)) == ""
    assert force_unit_doubt(np.zeros(5), (0.5, 7.0)) == ""


@pytest.mark.parametrize(
    ("name", "seed", "cause"),
    [
        ("posture steps of 0.25 and 0.4 N", 0, "zero of force"),
        ("posture steps of 0.25 and 0.4 N", 5, "zero of force"),
        ("40 uV noise", 0, "rest level"),
        ("EMG lost in packets, 1 %", 2, "clock"),
    ],
)
def test_what_is_not_known_of_a_correction_stands_in_the_budget(name, seed, cause):
    """Sessions that were GOOD with b off by 20 % and more."""
    record = clean_record(seed)
    MISHAPS[name][0](record)
    found = judged(record).verdict
    assert found.verdict != "good"
    assert re.search(cause, " ".join(found.problems))


def test_a_muscle_of_few_units_follows_force_and_a_steady_one_does_not():
    few = replace(BASE, carrier="units-15", ramp="saturating", ramp_s=3.0, fs_hz=4000.0, presses=6, b_v=9e-6)
    found = [analysed(few, seed).trials for seed in range(8)]
    assert not any("does not rise" in remark for one in found for remark in one.remarks)
    steady = clean_record(3)
    MISHAPS["FDS of a muscle that is tense in presses"][0](steady)
    assert "FDS does not rise with force" in " ".join(judged(steady).verdict.problems)


def test_a_gain_of_ten_shows_in_rest_and_presses_alike():
    record = clean_record(60)
    MISHAPS["one channel x 10"][0](record)
    found = judged(record).verdict
    assert found.verdict == "usable"
    assert "EDC is 15 times as loud as FDS; are their gains right?" in found.problems
    loud = clean_record(60)  # a muscle that is as much louder, above the same noise
    loud.emg_v["FDS"] = 0.1 * loud.emg_v["FDS"] + 1e-6 * np.random.default_rng(1).standard_normal(loud.force_n.size)
    assert not any("gains" in problem for problem in judged(loud).verdict.problems)
