from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from casr.errors import PinsError
from casr.flow.pin_affine import fit_affine
from emg2vsa.worlds.tactile import TACTIP_127

PINS = TACTIP_127.pins_px((149.5, 149.5))
entries = st.floats(-0.3, 0.3)


@given(entries, entries, entries, entries, st.floats(-50, 50), st.floats(-50, 50))
def test_an_affine_motion_is_recovered(a, b, c, d, dx, dy):
    matrix = np.array([[a, b], [c, d]])
    fit = fit_affine(PINS, PINS + (PINS - 100) @ matrix.T + (dx, dy))
    assert fit.matrix == pytest.approx(matrix, abs=1e-12)
    assert fit.displacement_px(np.array([[100.0, 100.0]])) == pytest.approx(np.array([[dx, dy]]), abs=1e-9)
    assert (fit.n, fit.notes) == (127, ())


def test_nothing_moved_is_exactly_nothing():
    fit = fit_affine(PINS, PINS.copy())
    assert not fit.matrix.any()
    assert not fit.offset_px.any()


@given(st.integers(0, 2**32 - 1))
def test_order_and_place_of_the_image_do_not_matter(seed):
    rng = np.random.default_rng(seed)
    after = PINS * 1.01 + rng.normal(0, 0.01, PINS.shape)
    order, shift = rng.permutation(127), rng.uniform(-500, 500, 2)
    fit, moved = fit_affine(PINS, after), fit_affine(PINS[order] + shift, after[order] + shift)
    assert moved.matrix == pytest.approx(fit.matrix, abs=1e-10)


@pytest.mark.parametrize("n_wrong", [1, 5])
def test_a_pin_taken_for_its_neighbour_is_left_out_with_a_note(n_wrong):
    after = PINS * 1.02 + np.random.default_rng(0).normal(0, 0.01, PINS.shape)
    good = fit_affine(PINS[n_wrong:], after[n_wrong:])
    after[:n_wrong] += (20.0, 0.0)
    fit = fit_affine(PINS, after)
    assert fit.matrix == pytest.approx(good.matrix, abs=1e-12)
    assert fit.n == 127 - n_wrong
    assert fit.notes == ("pins mistaken for others are left out",)


def test_a_skin_that_bulges_in_part_loses_no_pin():
    bulge = np.exp(-((np.hypot(*(PINS - 149.5).T) / 40) ** 2))[:, None] * (5.0, 0.0)
    assert fit_affine(PINS, PINS + bulge).n == 127


def test_lost_pins_are_as_if_they_had_never_been():
    after = PINS * 1.03 + np.random.default_rng(0).normal(0, 0.01, PINS.shape)
    lost = after.copy()
    lost[:20] = np.nan
    assert fit_affine(PINS, lost).matrix == pytest.approx(fit_affine(PINS[20:], after[20:]).matrix, abs=1e-13)
    assert fit_affine(PINS, lost).n == 107


@pytest.mark.parametrize(
    "pins",
    [PINS[:2], np.full((9, 2), np.nan), np.outer(np.arange(9.0), (1.0, 2.0)), np.ones((5, 2)), np.empty((0, 2))],
    ids=["two", "all lost", "on a line", "one place", "none"],
)
def test_too_few_pins_say_so(pins):
    with pytest.raises(PinsError, match="3 or more"):
        fit_affine(pins, pins)
