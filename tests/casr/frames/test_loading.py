"""Where loading starts and ends, and which frame is static."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from casr.errors import FramesError, NoContactError, SettingError
from casr.frames import loading_phase

PRESS = [0.0, 0.01, -0.01, 0.0, 0.2, 0.4, 0.6, 2.0, 4.0, 7.0, 5.0, 1.0, 0.2, 0.0]


def test_from_first_contact_to_the_largest_force():
    phase = loading_phase(PRESS)
    np.testing.assert_array_equal(phase.frames, [6, 7, 8, 9])
    assert phase.notes == ()


def test_the_static_frame_is_the_last_at_rest_and_not_on_the_ramp():
    assert loading_phase(PRESS).rest == 3


def test_a_touch_well_below_the_start_is_no_rest():
    # 0.04 N lies in the resting band, yet the skin is touched
    assert loading_phase([0, 0.003, 0.001, -0.001, 0.038, 0.12, 0.3, 0.6, 5.0]).rest == 3


def test_a_pull_of_the_leaving_skin_is_no_rest():
    light_touch_first = [0, 0, 0.3, 2, 3, 1, 0.1, -0.3, -0.2, -0.1, 0, 0.01, 0, -0.01, 0.2, 0.7, 6, 7, 0]
    assert loading_phase(light_touch_first).rest == 13


def test_a_recording_without_rest_uses_the_lightest_touch_and_says_so():
    phase = loading_phase([0.2, 0.3, 0.4, 0.7, 3.0])
    assert phase.rest == 0
    assert any("rests at 0.2 N" in note for note in phase.notes)


def test_loading_ends_where_stop_n_is_first_reached():
    np.testing.assert_array_equal(loading_phase(PRESS, stop_n=3.0).frames, [6, 7, 8])


def test_chatter_before_contact_is_not_the_press():
    phase = loading_phase([0, 0, 0.51, 0.49, 0.3, 0, 0.52, 0.48, 0.6, 3, 7, 1])
    np.testing.assert_array_equal(phase.frames, [8, 9, 10])
    assert phase.rest == 5


def test_of_several_presses_the_first_is_taken_with_a_note():
    two = [*PRESS, 0.0, 0.0, 0.3, 0.7, 3.0, 7.2, 3.0, 0.0]
    phase = loading_phase(two)
    np.testing.assert_array_equal(phase.frames, [6, 7, 8, 9])
    assert phase.notes == ("2 presses in the sequence; the first is used",)


def test_frames_without_force_are_skipped_with_a_note():
    force = np.array(PRESS)
    force[[3, 7]] = np.nan
    phase = loading_phase(force)
    np.testing.assert_array_equal(phase.frames, [6, 8, 9])
    assert phase.rest == 2
    assert any("1 frames of the loading carry no force" in note for note in phase.notes)


def test_dips_stay_in_and_are_counted():
    phase = loading_phase([0, 0, 0.6, 2, 1.9, 3, 2.5, 7, 0])
    np.testing.assert_array_equal(phase.frames, [2, 3, 4, 5, 6, 7])
    assert phase.notes == ("the force falls in 2 of 5 steps (40%), at most by 0.5 N",)


@given(
    st.lists(st.floats(-0.1, 0.4), min_size=1, max_size=20),
    st.lists(st.floats(0.51, 9), min_size=2, max_size=30),
    st.lists(st.floats(-0.1, 0.4), max_size=20),
)
def test_the_unloading_is_never_in(before, contact, after):
    contact[0] = 0.5
    force = np.array(before + contact + after)
    phase = loading_phase(force)
    np.testing.assert_array_equal(phase.frames, np.arange(len(before), np.argmax(force) + 1))
    assert 0 <= phase.rest < len(before)
    np.testing.assert_array_equal(loading_phase(force * 2, start_n=1.0).frames, phase.frames)


@given(st.integers(0, 10_000))
def test_noise_at_rest_does_not_move_the_static_frame_onto_the_ramp(seed):
    rng = np.random.default_rng(seed)
    ramp = np.concatenate([np.zeros(20), np.linspace(0, 7, 71)[1:]])
    phase = loading_phase(ramp + rng.normal(0, 0.01, ramp.size))
    assert phase.rest < 21
    assert phase.rest > 5


def test_no_contact_says_how_much_force_there_was():
    with pytest.raises(NoContactError, match=r"0.5 N or more, but found at most 0.3 N"):
        loading_phase([0.0, 0.3, 0.1])


@pytest.mark.parametrize(
    ("force", "asked", "message"),
    [
        ([], {}, "found none"),
        ([np.nan, np.nan], {}, "found none"),
        ([1.0, 2.0, 3.0], {}, "starts in contact"),
        ([0.0, 7.0, 0.0], {}, "within one frame"),
        ([0.0, 1.0, 2.0], {"stop_n": 3.0}, "at most 2 N"),
    ],
)
def test_forces_that_hold_no_loading(force, asked, message):
    with pytest.raises(FramesError, match=message):
        loading_phase(force, **asked)


@pytest.mark.parametrize("asked", [{"start_n": 0.0}, {"start_n": np.nan}, {"stop_n": 0.5}, {"stop_n": np.inf}])
def test_settings_that_make_no_sense(asked):
    with pytest.raises(SettingError):
        loading_phase(PRESS, **asked)
