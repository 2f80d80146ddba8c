"""Spikes, held values, missing samples and saturation: found where they were put, bridged, and put right."""

import numpy as np
import pytest

from benchmarks.laboratory import Laboratory, simulate_session
from emg2vsa.signals.clipping import MOST, Rail, law_of, unclipped
from emg2vsa.signals.gaps import bridge

FS_HZ = 1000.0


def recorded(carrier: str = "60/120", **disturbance: float) -> tuple[np.ndarray, np.ndarray]:
    laboratory = Laboratory(carrier=carrier, presses=3, **disturbance)
    made = simulate_session(laboratory, 7)
    span = made.onset_s[:, None] + np.array([0.5, 7.0]) / 7.5 * laboratory.ramp_s
    return made.emg_v, (span * FS_HZ).astype(int)


def whole(emg_v: np.ndarray) -> list[np.ndarray]:
    return [np.zeros(row.size, dtype=bool) for row in emg_v]


@pytest.mark.parametrize("carrier", ["60/120", "20/45", "laplacian", "units-15", "units-6"])
def test_spikes_are_bridged_and_nothing_else(carrier):
    emg_v, presses = recorded(carrier)
    rows = list(emg_v)
    untouched = bridge(rows, whole(emg_v), FS_HZ, presses)
    assert all(own is row for own, row in zip(untouched.samples, rows, strict=True))
    assert not untouched.spiked.any()
    spoilt = emg_v.copy()
    begin = int(presses[0, 0])
    # two that are near, one in the rest before the press
    for at in (begin + 300, begin + 305, begin - 400):
        spoilt[1, at] += 5e-3
    found = bridge(spoilt, whole(emg_v), FS_HZ, presses)
    np.testing.assert_array_equal(found.samples[0], spoilt[0])
    changed = np.flatnonzero(found.samples[1] != spoilt[1])
    assert set(changed) <= {*range(begin + 299, begin + 307), *range(begin - 401, begin - 398)}
    assert np.abs(found.samples[1] - emg_v[1]).max() < np.abs(emg_v[1]).max() * 2
    assert found.spiked[0] > 0
    assert not found.spiked[1:].any()
    assert not any(len(spans) for spans in found.lost)


def test_of_a_spike_of_some_samples_all_are_bridged():
    emg_v, presses = recorded()
    begin = int(presses[0, 0]) + 300
    emg_v[0, begin : begin + 6] += 5e-3
    found = bridge(list(emg_v), whole(emg_v), FS_HZ, presses)
    assert np.abs(found.samples[0]).max() < 1e-3


def test_a_value_that_is_held_is_bridged_and_left_out():
    emg_v, presses = recorded()
    begin = int(presses[1, 0]) + 500
    emg_v[0, begin : begin + 60] = emg_v[0, begin]
    found = bridge(emg_v, whole(emg_v), FS_HZ, presses)
    assert [spans.tolist() for spans in found.lost] == [[[begin, begin + 60]], []]
    line = found.samples[0][begin : begin + 60]
    assert np.ptp(np.diff(line)) < 1e-12


def test_lines_drawn_over_lost_packets_are_left_out_and_counted():
    emg_v, presses = recorded()
    first, last = presses[1].tolist()
    begin = first + 500
    emg_v[0, begin : begin + 40] = np.linspace(emg_v[0, begin - 1], emg_v[0, begin + 40], 42)[1:-1]
    found = bridge(np.round(emg_v, 14), whole(emg_v), FS_HZ, presses)
    ((span,), other) = found.lost
    assert other.size == 0
    assert span == pytest.approx([begin, begin + 40], abs=1)
    assert found.held[:, 1] == pytest.approx([42 / (last - first), 0], abs=2e-3)
    for at in range(first, last - 20, 100):  # a fifth of the press: no gap any more
        emg_v[0, at : at + 20] = 0.0
    spoilt = bridge(emg_v, whole(emg_v), FS_HZ, presses)
    assert spoilt.held[0, 1] == pytest.approx(0.2, abs=0.03)
    assert not spoilt.lost[0].size


def test_what_is_missing_is_left_out_where_it_is_long_and_kept_where_it_is_most():
    emg_v, presses = recorded()
    absent = whole(emg_v)
    first = int(presses[0, 0]) + 400
    absent[0][first : first + 5] = True
    absent[1][first : first + 40] = True
    absent[1][presses[2, 0] : presses[2, 0] + 500] = True
    found = bridge(emg_v, absent, FS_HZ, presses)
    assert [spans.tolist() for spans in found.lost] == [[], [[first, first + 40]]]
    np.testing.assert_allclose(found.missed, [40 / (presses[0, 1] - presses[0, 0]), 0, 0])


def test_a_channel_sampled_slowly_has_no_gaps():
    emg_v, presses = recorded()
    slow = np.repeat(emg_v[:, ::20], 20, axis=1)
    found = bridge(slow, whole(slow), FS_HZ, presses)
    assert not any(len(spans) for spans in found.lost)


@pytest.mark.parametrize("law", [0.0, 1.0])
def test_the_level_behind_a_rail_is_that_before_it(law):
    rng = np.random.default_rng(2)
    samples = rng.laplace(0, 1, 400_000) if law else rng.standard_normal(400_000) * np.sqrt(np.pi / 2)
    rail = 2.0
    level = np.array([np.abs(np.clip(samples, -rail, rail)).mean()])
    own, gauss, laplace = unclipped(level, Rail(rail, law))
    assert own[0] == pytest.approx(1.0, rel=0.01)
    assert own[0] == pytest.approx((gauss, laplace)[round(law)][0])
    assert law_of([samples], 200) == pytest.approx(law, abs=0.1)


def test_one_side_that_saturates_takes_half_as_much():
    level = np.array([0.4])
    both, one = (unclipped(level, Rail(1.0, 0.0, sides))[0] / level - 1 for sides in (2, 1))
    assert one == pytest.approx(both / 2)
    assert both > 0


def test_a_square_wave_and_a_soft_rail_tell_nothing_of_what_was():
    assert unclipped(np.array([0.3, MOST + 0.01]), Rail(1.0, 0.5)) is None
    assert unclipped(np.array([0.3]), Rail(1.0, 0.5, hard=False)) is None
