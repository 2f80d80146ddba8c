"""The contact region, and the affine motion of its pins."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from casr.flow.pin_engine import fit_affine
from casr.flow.region import Affine, Region
from emg2vsa.worlds.tactile import TACTIP_127

number = st.floats(-50, 50)


def affine(matrix: list[list[float]], offset: tuple[float, float] = (0, 0)) -> Affine:
    return Affine(np.array(matrix), np.array(offset, float), np.zeros(2), 0.0, 3)


def test_circle_has_the_area_of_a_circle() -> None:
    assert Region.circle(10, 20, 7).area_px2 == pytest.approx(np.pi * 49, rel=1e-12)
    np.testing.assert_allclose(Region.circle(10, 20, 7).centre_px, (10, 20), atol=1e-12)


@given(number, number, st.floats(1, 40), st.floats(1, 40), st.floats(0, 180))
def test_ellipse_keeps_area_and_centre_when_turned(x: float, y: float, a: float, b: float, turn: float) -> None:
    region = Region.ellipse(x, y, a, b, turn_deg=turn)
    assert region.area_px2 == pytest.approx(np.pi * a * b, rel=1e-9)
    np.testing.assert_allclose(region.centre_px, (x, y), atol=1e-9)


def test_ellipse_lies_along_its_direction() -> None:
    region = Region.ellipse(0, 0, 10, 2, turn_deg=90)
    assert np.ptp(region.polygon_px[:, 1]) == pytest.approx(20, rel=0.01)
    assert np.ptp(region.polygon_px[:, 0]) == pytest.approx(4, rel=0.01)


def test_hull_leaves_out_inner_points() -> None:
    corners = np.array([[0, 0], [4, 0], [4, 4], [0, 4]], float)
    hull = Region.from_points(np.vstack([corners, [[1, 1], [2, 3]]]))
    assert len(hull.polygon_px) == 4
    assert hull.area_px2 == pytest.approx(16)


@given(st.floats(0.1, 3), number, number)
def test_depth_is_the_scale_that_just_holds_a_point(factor: float, x: float, y: float) -> None:
    region = Region.ellipse(x, y, 12, 5, turn_deg=30)
    np.testing.assert_allclose(region.depth(region.scaled(factor).polygon_px), factor, rtol=1e-9)
    assert region.depth(region.centre_px[None])[0] == pytest.approx(0, abs=1e-9)


def test_depth_does_not_mind_the_sense_of_the_outline() -> None:
    square = np.array([[0, 0], [2, 0], [2, 2], [0, 2]], float)
    points = np.array([[1.5, 1.0], [1.0, 3.0]])
    np.testing.assert_allclose(Region(square).depth(points), (0.5, 2.0))
    np.testing.assert_allclose(Region(square[::-1]).depth(points), (0.5, 2.0))


def test_contains_follows_a_dent() -> None:
    dented = Region(np.array([[0, 0], [4, 0], [4, 4], [2, 1], [0, 4]], float))
    points = np.array([[2.0, 0.5], [2.0, 2.0], [3.7, 3.0], [5.0, 1.0]])
    assert dented.contains(points).tolist() == [True, False, True, False]


@given(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
def test_growth_of_an_affine_motion_is_its_trace_and_determinant(a: float, b: float, c: float, d: float) -> None:
    region = Region.ellipse(40, 60, 30, 20)
    motion = affine([[a, b], [c, d]], (3, -2))
    divergence, log_growth = region.growth_to(region.advanced(motion))
    assert divergence == pytest.approx(a + d, abs=1e-9)
    assert log_growth == pytest.approx(np.log((1 + a) * (1 + d) - b * c), abs=1e-9)


def test_growth_of_a_region_that_stays_is_exactly_zero() -> None:
    region = Region.circle(151.3, 148.7, 31.9)
    assert region.growth_to(Region(region.polygon_px)) == (0.0, 0.0)


def test_box_is_clipped_to_the_image() -> None:
    assert Region.circle(5, 50, 10).box((100, 60), margin_px=2) == (0, 37, 19, 64)


def test_text_of_the_command_line() -> None:
    np.testing.assert_allclose(Region.parse("150, 140,60").centre_px, (150, 140))


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
