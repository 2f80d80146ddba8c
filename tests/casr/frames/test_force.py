"""One force for each frame: of the rows that carry it, or at its exposure."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from casr.frames import force_per_frame
from casr.frames.force import force_at_exposure


def test_mean_of_the_rows_that_carry_the_frame():
    force = force_per_frame([9, 1, 2, 3, 10, 20, 5], [-1, 0, 0, 0, 1, 1, 3], 5, rule="mean")
    np.testing.assert_array_equal(force, [2, 15, np.nan, 5, np.nan])


def test_rows_without_force_do_not_count():
    force = force_per_frame([1, np.nan, 3, np.nan], [0, 0, 0, 1], 2, rule="mean")
    np.testing.assert_array_equal(force, [2, np.nan])


@given(st.lists(st.tuples(st.floats(-100, 100), st.integers(-1, 6)), min_size=1), st.randoms())
def test_the_order_of_rows_does_not_matter(rows, random):
    shuffled = rows.copy()
    random.shuffle(shuffled)
    one, other = (force_per_frame(*zip(*given, strict=True), 7, rule="mean") for given in (rows, shuffled))
    np.testing.assert_allclose(one, other, atol=1e-12)
    for frame in range(7):
        mine = [force for force, index in rows if index == frame]
        assert np.isnan(one[frame]) if not mine else one[frame] == pytest.approx(np.mean(mine), abs=1e-12)


def test_force_at_exposure_of_an_even_ramp_is_exact():
    time_s = np.arange(0, 1, 0.005)
    frame_s = np.array([0.1025, 0.1525, 0.2025, 0.4025, 0.4525])  # frames lost between the third and the fourth
    index = np.searchsorted(frame_s, time_s) - 1
    force = force_per_frame(3 * time_s, index, 5)
    np.testing.assert_allclose(force[1:4], 3 * frame_s[1:4], atol=1e-9)
    late = force_per_frame(3 * time_s, index, 5, rule="mean")
    assert late[1] - 3 * frame_s[1] == pytest.approx(3 * 0.025)


def test_a_frame_after_one_without_rows_keeps_its_mean():
    np.testing.assert_array_equal(force_per_frame([1, 2, 4, 8], [0, 0, 2, 2], 3), [1.5, np.nan, 6])


FRAME_S = np.arange(8) / 20


@given(st.floats(0, 0.0049), st.floats(0, 0.049), st.floats(-1e3, 1e3), st.floats(0, 1e6))
def test_an_even_ramp_is_exact_wherever_rows_and_frames_fall(row_phase_s, frame_phase_s, slope, start_s):
    time_s = start_s + row_phase_s + np.arange(-20, 120) / 200
    frame_s = start_s + frame_phase_s + FRAME_S
    np.testing.assert_allclose(
        force_at_exposure(frame_s, time_s, slope * (time_s - start_s)), slope * (frame_s - start_s), atol=1e-4
    )


def test_five_readings_share_the_noise():
    rng = np.random.default_rng(1)
    frame_s = np.arange(2000) / 20 + 0.0013
    time_s = np.arange(-20, 20100) / 200
    noise_n = rng.normal(0, 0.01, time_s.size)
    found = force_at_exposure(frame_s, time_s, 10 * time_s + noise_n)
    assert np.std(found - 10 * frame_s) == pytest.approx(0.01 / np.sqrt(5), rel=0.1)


def test_where_contact_begins_only_the_readings_near_it_count():
    time_s = np.arange(0, 80) / 200
    force = force_at_exposure(FRAME_S, time_s, 40 * np.maximum(0, time_s - 0.13))
    np.testing.assert_allclose(force, 40 * np.maximum(0, FRAME_S - 0.13), atol=1e-9)


def test_few_readings_lie_on_either_side():
    frame_s = np.arange(5) / 20
    found = force_at_exposure(frame_s, np.array([0.07, 0.09, 0.13]), np.array([7.0, 9.0, 13.0]))
    np.testing.assert_allclose(found, [np.nan, 7.0, 10.0, 13.0, np.nan])
    assert force_at_exposure(np.array([0.03]), np.array([0.02, 0.04]), np.array([2.0, 4.0])) == [3.0]


def test_the_same_reading_twice_is_no_line():
    time_s = np.array([0.0, 0.049, 0.049, 0.049, 0.1, 0.1])
    found = force_at_exposure(np.array([0.05, 0.1]), time_s, 10 * time_s)
    np.testing.assert_allclose(found, [0.5, 1.0])


def test_unknown_times_have_no_force():
    time_s = np.arange(0, 80) / 200
    frame_s = np.where(np.arange(8) == 3, np.nan, FRAME_S)
    np.testing.assert_allclose(force_at_exposure(frame_s, time_s, time_s), frame_s, atol=1e-9)
    assert np.isnan(force_at_exposure(FRAME_S, np.empty(0), np.empty(0))).all()


def test_a_log_with_both_times_is_read_by_them():
    time_s = np.arange(0, 80) / 200
    frame_s = FRAME_S + 0.004  # just before a row, where counted rows are half a row too early
    index = np.searchsorted(frame_s, time_s, side="right") - 1
    of_row = np.where(index >= 0, frame_s[index], np.nan)
    times = {"time_s": time_s, "frame_time_s": of_row}
    timed = force_per_frame(40 * time_s, index, 8, **times)
    np.testing.assert_allclose(timed, 40 * frame_s, atol=1e-9)
    assert np.abs(force_per_frame(40 * time_s, index, 8) - 40 * frame_s)[1:].max() > 0.05
    by_mean = force_per_frame(40 * time_s, index, 8, rule="mean")
    np.testing.assert_array_equal(force_per_frame(40 * time_s, index, 8, rule="mean", **times), by_mean)


def test_a_missing_force_or_frame_is_left_out():
    time_s = np.arange(0, 80) / 200
    index = np.repeat(np.arange(8), 10)
    index[index == 5] = 4  # saved in the same turn as frame 6: its time is not known
    force_n = np.where(np.arange(80) % 7 == 3, np.nan, 3 * time_s)
    found = force_per_frame(force_n, index, 8, time_s=time_s, frame_time_s=FRAME_S[index])
    np.testing.assert_allclose(found, np.where(np.arange(8) == 5, np.nan, 3 * FRAME_S), atol=1e-9)


def test_an_empty_column_of_times_leaves_the_rows_to_tell():
    time_s, index = np.arange(0, 80) / 200, np.repeat(np.arange(8), 10)
    counted, nothing = force_per_frame(time_s, index, 8), np.full(80, np.nan)
    for times in ((nothing, FRAME_S[index]), (time_s, nothing)):
        found = force_per_frame(time_s, index, 8, time_s=times[0], frame_time_s=times[1])
        np.testing.assert_array_equal(found, counted)


def test_the_first_known_time_of_a_frame_counts():
    time_s, index = np.arange(0, 80) / 200, np.repeat(np.arange(8), 10)
    of_row = np.where(np.arange(80) % 10 < 3, np.nan, FRAME_S[index])
    found = force_per_frame(3 * time_s, index, 8, time_s=time_s, frame_time_s=of_row)
    np.testing.assert_allclose(found, 3 * FRAME_S, atol=1e-9)


@pytest.mark.parametrize("apart_s", [2e-6, 5e-5, 2e-4, 5e-4])
def test_readings_that_come_in_packets_are_no_line(apart_s):
    rng = np.random.default_rng(3)
    time_s = np.sort(np.add.outer(np.arange(0, 0.4, 0.015), apart_s * np.arange(3)).ravel())
    found = force_at_exposure(FRAME_S, time_s, 2 * time_s + rng.normal(0, 0.01, time_s.size))
    assert np.abs(found - 2 * FRAME_S).max() < 0.05


def test_a_gap_of_the_force_is_not_bridged():
    time_s = np.arange(0, 80) / 200
    read = (time_s < 0.06) | (time_s > 0.29)
    found = force_at_exposure(FRAME_S, time_s[read], time_s[read])
    np.testing.assert_allclose(found[[0, 1, 2, 5, 6, 7]], FRAME_S[[0, 1, 2, 5, 6, 7]], atol=1e-9)
    assert np.isnan(found[[3, 4]]).all()
