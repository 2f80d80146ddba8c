"""What the sensor reads at rest."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from casr.frames import ForceZero, RestingForce, force_zero, notes_on_zero


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
    assert plain is not None
    assert shifted is not None
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
    assert zero is not None
    assert abs(zero.level_n) < 0.02


def test_contact_is_judged_from_the_level_so_far():
    rest = RestingForce(0.5)
    assert [rest.touches(force) for force in (0.4, 0.4, 0.4, 0.6, 0.89, 0.91, 0.6)] == [False] * 5 + [True, False]
    assert rest.zero is not None
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
