"""Movement of electrodes: told where it is, nowhere else, and left out of the envelopes that remember it."""

import numpy as np
import pytest

from benchmarks.laboratory import Laboratory, simulate_session
from emg2vsa.signals.movement import bridged, change_by_disturbance, left_out, movement

FS_HZ = 1000.0


def presses_of(laboratory: Laboratory, seed: int) -> tuple[list[np.ndarray], np.ndarray, np.ndarray]:
    made = simulate_session(laboratory, seed)
    span = made.onset_s[:, None] + np.array([0.5, 7.0]) / 7.5 * laboratory.ramp_s
    rests = made.onset_s[:, None] - np.array([1.2, 0.2])
    return list(made.emg_v), (span * laboratory.fs_hz).astype(int), (rests * laboratory.fs_hz).astype(int)


@pytest.mark.parametrize("carrier", ["60/120", "40/80", "90/180", "20/45", "laplacian", "units-60", "units-6"])
def test_clean_presses_do_not_move(carrier):
    for seed in range(3):
        assert not any(len(spans) for spans in movement(*_with_rate(presses_of(Laboratory(carrier=carrier), seed))))


def _with_rate(made):
    samples, presses, rests = made
    return samples, FS_HZ, presses, rests


@pytest.mark.parametrize(("size_v", "length_s"), [(50e-6, 0.06), (150e-6, 0.1), (500e-6, 0.06)])
def test_a_pulse_is_found_where_it_is(size_v, length_s):
    samples, presses, rests = presses_of(Laboratory(), 5)
    at = presses[:, 0] + 400
    pulse = size_v * np.hanning(round(length_s * FS_HZ))
    for begin in at.tolist():
        samples[1][begin : begin + pulse.size] += pulse
    quiet, moved = movement(samples, FS_HZ, presses, rests)
    assert len(quiet) == 0
    assert len(moved) == len(at)
    assert np.all(moved[:, 0] <= at)
    assert np.all(moved[:, 1] >= at + pulse.size)
    assert np.all(moved[:, 1] - moved[:, 0] < 1000 * length_s + 250)


def test_what_comes_with_every_contact_is_found_though_emg_is_slow_itself():
    """50 uV in a carrier of 20 to 45 Hz stand out from no single press."""
    found = 0
    for seed in range(4):
        samples, presses, rests = presses_of(Laboratory(carrier="20/45", artefact_v=50e-6), seed)
        for spans in movement(samples, FS_HZ, presses, rests):
            near = np.abs(spans.mean(axis=1)[:, None] - presses[:, 0]).min(axis=1, initial=10**9)
            assert np.all(near < 250)
            found += len(spans)
    assert found > 30


def test_what_remembers_a_span_is_left_out_and_bridged():
    at = np.arange(0, 1000, 10)
    gone = left_out([np.array([[300, 340]]), np.empty((0, 2), int)], at, before=50, after=30)
    assert at[gone].tolist() == list(range(280, 390, 10))
    rising = np.tile(np.linspace(1, 2, at.size), (2, 1))
    spoilt = np.where(gone, 9.0, rising)
    np.testing.assert_allclose(bridged(spoilt, gone, np.array([0, at.size])), rising)


def test_the_change_is_that_of_the_slope():
    force_n = np.geomspace(0.5, 7, 200)
    activity = 30 + 15 * np.log(force_n)
    spoilt = activity + np.where(force_n < 0.7, 30.0, 0.0)
    kept = force_n >= 0.7
    with_it, without = (spoilt, np.ones(200, dtype=bool)), (spoilt, kept)
    shift = change_by_disturbance("contact artefact", force_n, activity, np.array([0, 200]), with_it, without, 0.1)
    whole, without = (np.polyfit(np.log(force_n), y, 1, w=1 / activity)[0] for y in (spoilt, activity))
    assert shift.cause == "contact artefact"
    assert shift.b_se[0] == 0.1
    assert shift.corrected[0] == pytest.approx(whole / without - 1, abs=1e-6)
    assert not shift.b.any()
