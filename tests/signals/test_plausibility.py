"""Mishaps of a laboratory: each is told by its cause with a remedy, and nothing is said of a clean session."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.mishaps import MISHAPS, clean_record, judged
from benchmarks.verdict_thresholds import BASE, analysed
from emg2vsa.signals.plausibility import force_unit_doubt

UNHARMED = ("nothing", "drift 2 N over the record")
SAMPLE = (
    "EMG in uV labelled V", "EMG in V labelled mV", "one channel exported twice", "crosstalk 30 %",
    "contact fades to 0.2", "electrode off: slow wander", "clipping, 0.2 uV noise on the rails",
    "artefact at contact, 150 uV", "0.1 % spikes of 5 mV", "a 100 ms burst in one press", "ECG of 150 uV",
    "ECG of 60 uV, 160 a minute",
    "EMG rectified already", "EMG an RMS over 100 ms already", "lbf labelled N", "record begins in the first press",
    "EMG exported at 200 Hz", "packets of 27 samples sent twice", "force 200 ms late",
)  # fmt: skip


@pytest.mark.parametrize("name", SAMPLE)
def test_a_mishap_is_told_by_its_cause(name):
    spoil, word = MISHAPS[name]
    record = clean_record(11)
    spoil(record)
    found = judged(record)
    assert found.word != "good"
    assert word in found.said
    assert found.remedies


@pytest.mark.parametrize("name", UNHARMED)
def test_nothing_is_said_where_nothing_is_wrong(name):
    record = clean_record(12)
    MISHAPS[name][0](record)
    found = judged(record)
    assert (found.word, found.said) == ("good", "")


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
