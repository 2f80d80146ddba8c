"""Benchmark pairs: the flow is what the pins did, its divergence is as stated."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.tactile.flow_pairs import FlowPair, contact_pair, linear_pair
from emg2vsa.worlds.tactile import Appearance

PAIRS = [contact_pair, linear_pair]


def _divergence(pair: FlowPair) -> np.ndarray:
    flow = pair.flow.astype(np.float64)
    return np.gradient(flow[..., 0], axis=1) + np.gradient(flow[..., 1], axis=0)


def _distance(pair: FlowPair) -> np.ndarray:
    rows, columns = np.mgrid[:300, :300]
    return np.hypot(columns - pair.contact.centre_px[0], rows - pair.contact.centre_px[1])


@pytest.mark.parametrize("make", PAIRS)
@pytest.mark.parametrize("motion_px", [0.25, 1.0, 3.0])
def test_divergence_inside_is_as_stated(make: type[FlowPair], motion_px: float) -> None:
    pair = make(motion_px)
    np.testing.assert_allclose(_divergence(pair)[_distance(pair) < 78], pair.divergence, rtol=0, atol=1e-5)
    assert pair.divergence == pytest.approx(2 * motion_px / 80, rel=1e-12)


def test_contact_field_has_no_divergence_outside() -> None:
    pair = contact_pair(3.0)
    distance = _distance(pair)
    outside = (distance > 82) & (distance < 135)
    # central differences of k b^2 / r leave a little
    np.testing.assert_allclose(_divergence(pair)[outside], 0, atol=1e-4)


@pytest.mark.parametrize("make", PAIRS)
def test_pins_move_with_the_flow(make: type[FlowPair]) -> None:
    pair = make(1.0, seed=4)
    inside = np.hypot(*(pair.pins_first_px - pair.contact.centre_px).T) < 75
    moved = (pair.pins_second_px - pair.pins_first_px)[inside]
    expected = (pair.pins_first_px[inside] - pair.contact.centre_px) / 80
    np.testing.assert_allclose(moved, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("make", PAIRS)
def test_no_motion_gives_the_same_frame_but_for_noise(make: type[FlowPair]) -> None:
    pair = make(0.0, appearance=Appearance(noise_grey=0.0, texture_grey=8.0))
    np.testing.assert_array_equal(pair.first, pair.second)
    assert not pair.flow.any()
    noisy = make(0.0)
    assert (noisy.first.astype(int) - noisy.second)[noisy.mask].std() == pytest.approx(
        np.sqrt(2 * (4 + 1 / 12)), rel=0.02
    )


def test_linear_pair_dilates_the_image() -> None:
    pair = linear_pair(3.0, appearance=Appearance(noise_grey=0.0))
    bright = [(image.astype(float) - 20)[pair.mask].sum() for image in (pair.first, pair.second)]
    assert bright[1] / bright[0] == pytest.approx((1 + 3 / 80) ** 2, rel=2e-3)


def test_seeds_repeat_and_differ() -> None:
    np.testing.assert_array_equal(contact_pair(1.0, 7).second, contact_pair(1.0, 7).second)
    assert (contact_pair(1.0, 7).first != contact_pair(1.0, 8).first).any()
    assert contact_pair(1.0, 7).contact != contact_pair(1.0, 8).contact
