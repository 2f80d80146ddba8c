"""Neighbours, matches and pitch of pins; missing pins, stray blobs and other layouts, as the lattice shows them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from casr.pins import detect_pins, match_pins, pin_pitch_px, pins_in_doubt
from casr.pins.lattice import NEIGHBOURS, at_border, lattice_kind, lattice_sites, nearest_pins, on_lattice
from emg2vsa.worlds.tactile import TACTIP_127, Skin

PINS = TACTIP_127.pins_px((149.5, 149.5))


@given(st.integers(0, 2**32 - 1))
def test_order_of_the_rows_does_not_matter(seed):
    order = np.random.default_rng(seed).permutation(len(PINS))
    before, after = match_pins(PINS, PINS[order] + 0.3, max_distance_px=10)
    assert np.array_equal(order[after], before)
    assert len(before) == len(PINS)


@given(st.floats(-9, 9), st.floats(-9, 9))
def test_shifts_below_half_a_pitch_match_every_pin(dx, dy):
    if np.hypot(dx, dy) > 9.9:
        return
    before, after = match_pins(PINS, PINS + np.array([dx, dy]), max_distance_px=10)
    assert np.array_equal(before, after)
    assert len(before) == len(PINS)


@given(st.integers(0, 2**32 - 1), st.integers(0, 30), st.integers(0, 30))
def test_one_to_one_within_reach(seed, n, m):
    rng = np.random.default_rng(seed)
    a, b = rng.uniform(0, 50, (n, 2)), rng.uniform(0, 50, (m, 2))
    i, j = match_pins(a, b, max_distance_px=8)
    assert len(set(i)) == len(i) == len(set(j)) == len(j)
    assert (np.hypot(*(a[i] - b[j]).T) <= 8).all()
    back_j, back_i = match_pins(b, a, max_distance_px=8)
    assert set(zip(i, j, strict=True)) == set(zip(back_i, back_j, strict=True))


def test_of_two_that_claim_one_the_nearer_gets_it():
    i, j = match_pins(np.array([[0.0, 0], [3, 0]]), np.array([[2.0, 0]]), max_distance_px=5)
    assert (list(i), list(j)) == ([1], [0])


def test_reach_may_differ_from_pin_to_pin_and_lost_pins_match_nothing():
    before = np.array([[0.0, 0], [50, 0], [np.nan, np.nan]])
    i, _ = match_pins(before, np.array([[4.0, 0], [54, 0]]), max_distance_px=np.array([3.0, 5.0, 99.0]))
    assert list(i) == [1]


def test_pitch_is_the_spacing_of_the_lattice():
    assert pin_pitch_px(PINS) == pytest.approx(20)
    assert np.isnan(pin_pitch_px(PINS[:1]))


HEXAGON = TACTIP_127.pins_px((149.5, 149.5))
SQUARE = np.stack(np.meshgrid(np.arange(11) * 20.0, np.arange(9) * 20.0), axis=-1).reshape(-1, 2)


def turned(points_px, angle_deg, scatter_px=0.4, seed=0):
    angle = np.deg2rad(angle_deg)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return points_px @ turn + np.random.default_rng(seed).normal(0, scatter_px, points_px.shape)


@pytest.mark.parametrize("angle_deg", [0, 11, 45, 80])
@pytest.mark.parametrize(("grid", "kind"), [(HEXAGON, "hexagonal"), (SQUARE, "square")])
def test_kind_and_whole_lattice(grid, kind, angle_deg):
    pins = turned(grid, angle_deg)
    assert lattice_kind(pins) == kind
    assert (lattice_sites(pins).n_empty, lattice_sites(pins).n_beside) == (0, 0)
    assert pins_in_doubt(pins) == ()


@pytest.mark.parametrize("grid", [HEXAGON, SQUARE], ids=["hexagonal", "square"])
@pytest.mark.parametrize("n_missing", [1, 4, 12, 40])
def test_missing_pins_inside_the_array_are_counted(grid, n_missing):
    inner = np.flatnonzero(~at_border(grid, nearest_pins(grid, NEIGHBOURS)[1]))
    gone = np.random.default_rng(3).permutation(inner)[:n_missing]
    pins = np.delete(turned(grid, 7), gone, axis=0)
    assert lattice_sites(pins).n_empty == n_missing
    assert f"{n_missing} sites of the pin lattice show no pin" in pins_in_doubt(pins)


def test_a_dome_seen_from_behind_is_still_a_lattice():
    away = HEXAGON - 149.5
    dome = 149.5 + away * (1 - 1e-5 * (away**2).sum(axis=1, keepdims=True))
    assert pins_in_doubt(dome) == ()


def test_specks_beside_the_lattice_are_counted():
    specks = HEXAGON[[20, 100]] + (10.0, 5.8)
    assert any(note.startswith("2 of 129 pins stand beside") for note in pins_in_doubt(np.vstack([HEXAGON, specks])))


def test_random_blobs_are_no_lattice():
    blobs = np.random.default_rng(1).uniform(0, 300, (90, 2))
    assert not on_lattice(blobs)
    assert any("stand on no lattice: are they pins?" in note for note in pins_in_doubt(blobs))
    assert not on_lattice(blobs[:5])


def test_the_count_that_is_expected():
    assert pins_in_doubt(HEXAGON, 127) == ()
    assert pins_in_doubt(HEXAGON, 130) == ("127 pins are found at rest, not 130",)


def test_border_of_hexagon_and_square():
    for grid, n_border in ((HEXAGON, 36), (SQUARE, 36), (Skin(rings=2).pins_px((0.0, 0.0)), 12)):
        assert at_border(grid, nearest_pins(grid, NEIGHBOURS)[1]).sum() == n_border


def test_real_sensors_at_rest_or_nearly_so(shared_data: Callable[[str], Path]):
    flat = sorted(shared_data("tactile/tactip127_flat_press_640x480").glob("*.png"))
    raw = sorted(shared_data("tactile/tactip331_raw_640x480").glob("**/*.png"))
    for path in flat[::10]:
        pins = detect_pins(cv2.imread(str(path), cv2.IMREAD_UNCHANGED))
        assert pins_in_doubt(pins.centroids_px) == ()
    doubts = [pins_in_doubt(detect_pins(cv2.imread(str(path), cv2.IMREAD_UNCHANGED)).centroids_px) for path in raw]
    assert sum(doubt == () for doubt in doubts) >= 0.8 * len(doubts)
