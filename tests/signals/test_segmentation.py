"""Presses are found whatever the sensor's offset, drift and rate; failed ones too."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from emg2vsa.errors import SignalError
from emg2vsa.settings import ForceChannelSettings, WindowSettings
from emg2vsa.signals.force import condition_force
from emg2vsa.signals.rest import find_rest
from emg2vsa.signals.segmentation import find_presses

FS_HZ = 200.0
RESTS = ForceChannelSettings(name="Fz")
WINDOW_N = (0.5, 7.0)
RISE = [(0, 0), (2.5, 7.5), (2.8, 7.5), (3.5, 0)]


def force_of(*presses, rest_s=2.0, fs_hz=FS_HZ):
    """Rest, then each press given as (seconds, newtons) knots, each followed by rest."""
    knots, at = [(0.0, 0.0)], rest_s
    for press in presses:
        knots += [(at + t, f) for t, f in press]
        at += press[-1][0] + rest_s
    times, values = zip(*knots, strict=True)
    return np.interp(np.arange(0, at, 1 / fs_hz), times, values)


def starts_and_stops(force_n, window_n=WINDOW_N, fs_hz=FS_HZ):
    found = find_presses(force_n, fs_hz, window_n)
    return found.start_s, found.stop_s


def test_every_press_from_its_last_rise_to_its_first_reach():
    start, stop = starts_and_stops(force_of(RISE, RISE, RISE))
    offsets = 2.0 + 5.5 * np.arange(3)
    assert start == pytest.approx(offsets + 0.5 / 3, abs=1e-9)
    assert stop == pytest.approx(offsets + 7 / 3, abs=1e-9)


def test_a_dip_below_the_lower_force_restarts_the_press():
    dip = [(0, 0), (0.3, 2.0), (0.4, 0.3), (0.5, 0.3), (2.5, 7.5), (3.5, 0)]
    found = find_presses(force_of(dip), FS_HZ, WINDOW_N)
    assert found.start_s.size == 1
    assert found.start_s[0] > 2.5


def test_two_full_presses_close_together_are_two():
    double = [(0, 0), (1.0, 7.5), (1.2, 0.2), (1.3, 0.2), (2.5, 7.5), (3.0, 0)]
    assert find_presses(force_of(double), FS_HZ, WINDOW_N).reached.tolist() == [True, True]


def test_a_bounce_on_release_is_no_press_of_its_own():
    bounce = [*RISE, (3.55, 3.0), (3.7, 0)]
    assert find_presses(force_of(bounce), FS_HZ, WINDOW_N).start_s.size == 1


def test_a_press_that_fails_is_kept_and_a_touch_is_counted():
    fails, touch = [(0, 0), (2, 5.2), (3, 0)], [(0, 0), (0.5, 1.0), (1, 0)]
    found = find_presses(force_of(RISE, fails, touch, RISE), FS_HZ, WINDOW_N)
    assert found.reached.tolist() == [True, False, True]
    assert found.touches == 1
    assert found.peak_n[1] == pytest.approx(5.2, abs=0.03)


def test_a_record_that_begins_in_a_press():
    rising = np.interp(np.arange(0, 5, 0.005), [0, 2, 3], [2, 8, 0])
    found = find_presses(rising, FS_HZ, WINDOW_N)
    assert found.start_s.tolist() == [0.0]
    assert found.at_edge.tolist() == [True]
    assert found.reached.tolist() == [True]
    for falling in (9 - rising, rising[::-1] + 8):
        found = find_presses(np.maximum(falling[:350], 0), FS_HZ, WINDOW_N)
        assert found.start_s.size == 0
        assert found.skipped == 1


def test_a_record_that_ends_in_a_press():
    found = find_presses(force_of(RISE)[: round(4 * FS_HZ)], FS_HZ, WINDOW_N)
    assert found.reached.tolist() == [False]
    assert found.at_edge.tolist() == [True]


presses = st.lists(st.floats(3.0, 12.0), min_size=1, max_size=4)


@given(presses, st.integers(1, 400))
@settings(max_examples=40, deadline=None)
def test_later_means_later(peaks, shift):
    force = force_of(*[[(0, 0), (2, peak), (3, 0)] for peak in peaks])
    start, stop = starts_and_stops(force)
    moved = starts_and_stops(np.concatenate([np.zeros(shift), force]))
    assert moved[0] == pytest.approx(start + shift / FS_HZ)
    assert moved[1] == pytest.approx(stop + shift / FS_HZ)


@given(presses, st.floats(0.01, 100))
@settings(max_examples=40, deadline=None)
def test_unit_of_force_does_not_matter(peaks, scale):
    force = force_of(*[[(0, 0), (2, peak), (3, 0)] for peak in peaks])
    start, stop = starts_and_stops(force)
    scaled = starts_and_stops(scale * force, (scale * WINDOW_N[0], scale * WINDOW_N[1]))
    assert scaled[0] == pytest.approx(start, abs=1e-6)
    assert scaled[1] == pytest.approx(stop, abs=1e-6)


@given(st.floats(-40, 40), st.floats(-0.02, 0.02), st.integers(0, 2**32 - 1))
@settings(max_examples=25, deadline=None)
def test_offset_and_drift_of_the_sensor_do_not_matter(offset_n, drift_n_per_s, seed):
    force = force_of(*[RISE] * 5)
    noise = 0.005 * np.random.default_rng(seed).standard_normal(force.size)
    moved = force + noise + offset_n + drift_n_per_s * np.arange(force.size) / FS_HZ
    truth = starts_and_stops(force)
    found = condition_force(moved, FS_HZ, None, RESTS, WindowSettings())
    assert found.presses.start_s == pytest.approx(truth[0], abs=0.02)
    assert found.presses.stop_s == pytest.approx(truth[1], abs=0.02)
    assert found.tare_n == pytest.approx(offset_n + drift_n_per_s * force.size / FS_HZ / 2, abs=0.05)


def test_steps_of_the_zero_that_all_go_one_way_are_no_drift():
    force = force_of(*[RISE] * 6)
    force += 0.005 * np.random.default_rng(1).standard_normal(force.size)
    time_s = np.arange(force.size) / FS_HZ
    presses = condition_force(force, FS_HZ, None, RESTS, WindowSettings()).presses
    steps = sum(0.2 * (time_s > start_s) for start_s in presses.start_s.tolist())
    found = condition_force(force + steps, FS_HZ, None, RESTS, WindowSettings())
    assert found.zero_shift_n[1:-1] == pytest.approx([0.2] * 4, abs=0.03)
    drifting = condition_force(force + 0.05 * time_s, FS_HZ, None, RESTS, WindowSettings())
    assert np.nanmax(drifting.zero_shift_n) < 0.03


def test_the_slope_of_a_short_last_rest_leads_nowhere():
    """Real force: 30 s of grip, and the file ends while the hand lets go."""
    force = force_of([(0, 0), (3, 8), (30, 8), (31, 0.2), (31.7, 0)])[: -round(1.2 * FS_HZ)]
    found = condition_force(force, FS_HZ, None, RESTS, WindowSettings())
    assert found.rest.start.size == 2
    assert np.nanmax(found.zero_shift_n) < 0.3


def test_one_rest_at_which_the_hand_leans_does_not_move_the_tare():
    force = force_of(*[RISE] * 6)
    leaning = force.copy()
    leaning[round(13.5 * FS_HZ) : round(14.9 * FS_HZ)] = 0.2
    tared = condition_force(leaning, FS_HZ, None, RESTS, WindowSettings())
    assert np.max(np.abs(tared.force_n - leaning)) < 1e-9


@pytest.mark.parametrize(
    "force_n",
    [
        np.interp(np.arange(0, 20, 0.005), [0, 6, 14, 20], [1.6, 26, 26, 1.1]),
        np.interp(np.arange(0, 5, 0.005), [0, 1.4, 2, 4, 5], [23, 21, 90, 90, 7]),
        np.zeros(20),
    ],
)
def test_a_ramp_or_a_grip_never_rests(force_n):
    assert find_rest(force_n, FS_HZ, WindowSettings(force_n=(5.0, 25.0))).level_n.size == 0


def test_no_press_says_why():
    quiet = condition_force(np.zeros(2000), FS_HZ, None, RESTS, WindowSettings(expected_trials=10))
    assert any("0 found, 10 expected" in note for note in quiet.notes)
    assert quiet.sign_doubt == ""


@pytest.mark.parametrize("sign", [1, -1])
def test_no_press_of_a_reversed_force_asks_for_the_other_sign(sign):
    channel = ForceChannelSettings(name="Fz", sign=sign, tare="none")
    mirrored = condition_force(-force_of(RISE), FS_HZ, None, channel, WindowSettings())
    assert mirrored.sign_doubt.startswith("force goes down to -7.5 N")
    assert mirrored.sign_doubt.endswith(f"is its sign {-sign}?")
    upright = condition_force(force_of(RISE), FS_HZ, None, channel, WindowSettings())
    assert upright.sign_doubt == ""


@pytest.mark.parametrize("odd", [np.nan, np.inf, -np.inf])
def test_force_that_is_not_finite_is_refused(odd):
    force_n = force_of(RISE)
    force_n[int(np.argmax(force_n > WINDOW_N[0])) - 1] = odd  # from which force rises through the lower level
    with pytest.raises(
        SignalError, match=r"force to find presses in: expected finite samples, but found 1 of \d+ that"
    ):
        find_presses(force_n, FS_HZ, WINDOW_N)
    with pytest.raises(SignalError, match="expected 2 samples or more, but found 1"):
        find_presses(force_n[:1], FS_HZ, WINDOW_N)


def test_a_peak_of_a_few_milliseconds_is_no_press():
    spike = [(0, 0), (0.005, 7.6), (0.01, 0)]
    found = find_presses(force_of(RISE, spike, RISE), FS_HZ, WINDOW_N)
    assert found.start_s.size == 2
    assert found.touches == 1
