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


def test_units_of_force():
    wave = np.sin(np.linspace(0, np.pi, 100))
    for peak_n, unit in ((7.5 / 4.448, "lbf"), (7.5 / 9.81, "kgf"), (765.0, "gf"), (7500.0, "mN"), (7.5e-3, "kN")):
        assert f"is its unit {unit} " in force_unit_doubt(peak_n * wave, (0.5, 7.0))
    for peak_n in (7.2, 9.0, 5.6, 3.0, 100.0, 0.2):
        assert force_unit_doubt(peak_n * wave, (0.5, 7.0)) == ""
    assert force_unit_doubt(np.zeros(5), (0.5, 7.0)) == ""
