"""What the sensor reads at rest, where loading starts and ends, and which frame is static."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from casr.errors import CasrError
from casr.frames import ForceZero, RestingForce, force_zero, loading_phase, notes_on_zero


def press(seed: int, n_rest: int, rate_n: float, noise_n: float, zero_n: float = 0.0) -> np.ndarray:
    """Rest, then a rise of ``rate_n`` a frame that begins somewhere between two frames."""
    rng = np.random.default_rng(seed)
    since = np.arange(n_rest + 400) - (n_rest - 1 + rng.uniform())
    return zero_n + rate_n * np.clip(since, 0, None) + rng.normal(0, noise_n, since.size)


@pytest.mark.parametrize(("n_rest", "rate_n"), [(4, 0.1), (20, 0.1), (20, 0.01), (20, 0.005)])
def test_the_ramp_is_not_in_the_zero_and_its_error_is_told(n_rest, rate_n):
    found = [force_zero(press(seed, n_rest, rate_n, 0.004), 0.5) for seed in range(300)]
    assert all(found)
    error = np.array([zero.level_n for zero in found])
    told = np.array([zero.sd_n for zero in found])
    assert abs(error.mean()) < 0.001
    assert np.mean(np.abs(error) < 3 * told) > 0.9
    assert np.median(told) == pytest.approx(error.std(), rel=0.4)


@given(st.floats(-50, 50), st.integers(0, 1000))
def test_an_offset_is_found_whatever_it_is(zero_n, seed):
    plain, shifted = (force_zero(press(seed, 8, 0.1, 0.003, offset_n), 0.5) for offset_n in (0.0, zero_n))
    # an offset of contact's size or more puts the first frame in doubt, not the level
    assert shifted.level_n - zero_n == pytest.approx(plain.level_n, abs=0.004)


@pytest.mark.parametrize(
    "force_n",
    [[0.2, 0.3, 0.4, 0.7, 3.0], [0.0, 0.01, 2.0, 5.0], [1.0, 2.0, 3.0], [0.0, 0.0, np.nan, 1.0], [], [np.nan]],
    ids=["ramp", "two", "in contact", "unknown", "empty", "no force"],
)
def test_too_few_frames_at_rest_tell_no_zero(force_n):
    assert force_zero(force_n, 0.5) is None
    assert "not determined" in notes_on_zero(None, 0.5)[0]


def test_light_touches_and_pulls_after_the_first_contact_do_not_count():
    before = [0.02, 0.021, 0.019, 0.02]
    assert force_zero([*before, 0.7, 1.0, -0.3, -0.3, -0.3, -0.3, 0.1, 2.0], 0.5) == force_zero([*before, 2.0], 0.5)


def test_a_drift_counts_as_it_was_last():
    zero = force_zero([*np.linspace(-0.3, 0.0, 3000), *[0.0] * 150, 1.0], 0.5)
    assert abs(zero.level_n) < 0.02


def test_contact_is_judged_from_the_level_so_far():
    rest = RestingForce(0.5)
    assert [rest.touches(force) for force in (0.4, 0.4, 0.4, 0.6, 0.89, 0.91, 0.6)] == [False] * 5 + [True, False]
    assert rest.zero.level_n == pytest.approx(0.4)
    unsure = RestingForce(0.5)
    assert [unsure.touches(force) for force in (0.0, 0.3, 0.6)] == [False, False, True]
    assert unsure.zero is None
    assert unsure.level_n == 0


def test_notes_name_what_was_taken_off():
    assert notes_on_zero(ForceZero(0.01, 0.002, 9), 0.5) == ()
    assert notes_on_zero(ForceZero(0.4, 0.002, 9, taken_off=False), 0.5) == ()
    assert (
        "rests at 0.4 N (standard error 0.002 N), which is taken off" in notes_on_zero(ForceZero(0.4, 0.002, 9), 0.5)[0]
    )
    assert "is the sensor free" in notes_on_zero(ForceZero(0.6, 0.002, 9), 0.5)[0]


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


def test_a_press_that_turns_back_at_stop_n_between_two_frames_is_one():
    press = [0, 0, 0, 0.1, 0.3, 1.0, 2.5, 4.4, 2.0, 0.0]
    np.testing.assert_array_equal(loading_phase(press, stop_n=5.0).frames, [5, 6, 7])
    with pytest.raises(CasrError, match=r"5.6 N, or 80% of it, but found at most 4.4 N"):
        loading_phase(press, stop_n=5.6)


def test_of_presses_that_nearly_reach_stop_n_the_first_counts():
    press = [0, 0, 0, 0.1, 1.0, 4.4, 0.0, 0.1, 1.0, 3.0, 4.7, 0.0]
    np.testing.assert_array_equal(loading_phase(press, stop_n=5.0).frames, [4, 5])


def test_a_press_that_reaches_stop_n_goes_before_one_that_nearly_does():
    press = [0, 0, 0, 0.1, 1.0, 4.4, 0.0, 0.1, 1.0, 3.0, 5.1, 0.0]
    np.testing.assert_array_equal(loading_phase(press, stop_n=5.0).frames, [8, 9, 10])


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
