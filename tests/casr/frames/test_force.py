"""One force for each frame."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from casr.errors import FramesError, SettingError
from casr.frames import force_per_frame


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


def test_unknown_rule():
    with pytest.raises(SettingError, match="exposure or mean"):
        force_per_frame([1.0], [0], 1, rule="last")


@pytest.mark.parametrize(
    ("index", "found"),
    [([0, 3], "index 3"), ([-2, 1], "index -2"), ([0, 0.5], "0.5 in row 1"), ([0], "2 forces and 1")],
)
def test_indices_that_fit_no_frame_are_named(index, found):
    with pytest.raises(FramesError, match=found):
        force_per_frame([1.0, 2.0], index, 3)


def test_too_high_an_index_says_how_many_frames_there_are():
    with pytest.raises(FramesError, match=r"rig.csv: expected frame indices from -1 to 2, for there are 3 frames"):
        force_per_frame([1.0], [3], 3, where="rig.csv")
