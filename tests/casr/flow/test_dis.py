"""OpenCV's DIS behind one call."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.tactile.flow_pairs import contact_pair
from casr.errors import ImageError, SettingError
from casr.flow.dis import PRESETS, Dis, dis_flow


@pytest.mark.parametrize("preset", PRESETS)
def test_endpoint_error_in_the_contact(preset: str) -> None:
    pair = contact_pair(1.0)
    flow = dis_flow(pair.first, pair.second, preset=preset)
    rows, columns = np.mgrid[:300, :300]
    inside = pair.contact.depth(np.stack([columns, rows], axis=-1)) < 1
    assert np.hypot(*(flow - pair.flow)[inside].T).mean() < 0.12


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("shape", [(1, 1), (12, 200), (16, 200), (200, 24), (39, 39), (300, 41)])
def test_every_size_gives_a_finite_flow(preset: str, shape: tuple[int, int]) -> None:
    first, second = np.random.default_rng(0).integers(0, 255, (2, *shape), dtype=np.uint8)
    flow = dis_flow(first, second, preset=preset)
    assert flow.shape == (*shape, 2)
    assert np.isfinite(flow).all()


@pytest.mark.parametrize("preset", PRESETS)
def test_equal_and_constant_images_do_not_move(preset: str) -> None:
    image = contact_pair(1.0).first
    assert not dis_flow(image, image, preset=preset).any()
    assert not dis_flow(np.full((50, 60), 7, np.uint8), np.full((50, 60), 7, np.uint8), preset=preset).any()


def test_crops_that_are_not_contiguous() -> None:
    pair = contact_pair(1.0)
    crop = dis_flow(pair.first[50:250, 60:240], pair.second[50:250, 60:240])
    copy = dis_flow(pair.first[50:250, 60:240].copy(), pair.second[50:250, 60:240].copy())
    np.testing.assert_array_equal(crop, copy)


def test_other_types_are_rounded_to_bytes() -> None:
    pair = contact_pair(1.0)
    floats = dis_flow(pair.first.astype(np.float64), pair.second.astype(np.uint16) * np.uint16(257))
    np.testing.assert_array_equal(floats, dis_flow(pair.first, pair.second))


def test_sequence_fills_the_box_asked_for() -> None:
    pair = contact_pair(1.0)
    method = Dis()
    method.start(pair.first)
    flow = method.step(pair.second, (100, 110, 200, 190))
    assert np.isfinite(flow[110:190, 100:200]).all()
    assert np.isnan(flow[0, 0]).all()
    assert not method.step(pair.second, (0, 0, 50, 50))[:50, :50].any()


def test_mistakes_are_named() -> None:
    image = np.zeros((50, 60), np.uint8)
    with pytest.raises(SettingError, match="slow"):
        dis_flow(image, image, preset="slow")
    with pytest.raises(ImageError, match="one shape"):
        dis_flow(image, image[1:])
