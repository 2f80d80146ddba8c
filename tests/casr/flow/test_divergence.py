"""Divergence and growth of flow fields that are known."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from casr.flow.dense_engine import fit_field
from casr.flow.divergence import divergence, mean_divergence, region_mask
from casr.flow.region import Region


def field(
    matrix: list[list[float]], shape: tuple[int, int] = (80, 100), at: tuple[float, float] = (45, 38)
) -> NDArray[np.float32]:
    rows, columns = np.mgrid[: shape[0], : shape[1]]
    return np.asarray(np.stack([columns - at[0], rows - at[1]], axis=-1) @ np.array(matrix).T, dtype=np.float32)


def contact(stretch: float, edge_px: float, shape: tuple[int, int] = (200, 200)) -> NDArray[np.float32]:
    """Growing inside the edge, free of divergence outside."""
    flow = field([[stretch, 0], [0, stretch]], shape, at=(100, 100))
    distance = np.hypot(*(np.mgrid[: shape[0], : shape[1]] - 100))
    return flow * np.minimum(1, (edge_px / np.maximum(distance, 1)) ** 2)[..., None].astype(np.float32)


def test_linear_field_to_the_border_of_the_image() -> None:
    np.testing.assert_allclose(divergence(field([[0.02, 0.3], [-0.1, 0.05]])), 0.07, atol=2e-6)


def test_mean_over_the_contact_and_nothing_over_what_has_a_static_rim() -> None:
    flow = contact(0.01, 40)
    assert mean_divergence(flow, Region.circle(100, 100, 32).polygon_px) == pytest.approx(0.02, rel=1e-3)
    outside = 0.02 * (40 / 90) ** 2
    assert mean_divergence(flow, Region.circle(100, 100, 90).polygon_px) == pytest.approx(outside, rel=0.02)


def test_mask_has_the_area_of_the_polygon_whatever_the_subpixel() -> None:
    for radius in np.arange(20, 21, 0.09):
        region = Region.circle(30.3, 29.8, radius)
        assert region_mask(region.polygon_px, (60, 64)).sum() == pytest.approx(region.area_px2, rel=0.008)


def test_mask_outside_the_image_is_empty_there() -> None:
    mask = region_mask(Region.circle(0, 10, 8).polygon_px, (20, 20))
    assert mask[10, 0] == 1
    assert mask[10, 12] == 0


def test_fit_finds_the_affine_motion() -> None:
    matrix = [[0.02, 0.3], [-0.1, 0.05]]
    fit = fit_field(field(matrix), Region.ellipse(52, 41, 25, 14, turn_deg=20))
    np.testing.assert_allclose(fit.matrix, matrix, atol=1e-6)
    np.testing.assert_allclose(fit.displacement_px(np.array([[45.0, 38.0]])), 0, atol=1e-5)


def test_fit_of_a_region_over_the_image_border_uses_what_is_there() -> None:
    fit = fit_field(field([[0.02, 0], [0, 0.01]]), Region.circle(2, 40, 20))
    assert np.trace(fit.matrix) == pytest.approx(0.03, abs=1e-6)


def test_fit_of_no_flow_is_exactly_zero() -> None:
    fit = fit_field(np.zeros((80, 100, 2), np.float32), Region.circle(50, 40, 20))
    assert not fit.matrix.any()


def test_fit_minds_the_fold_at_the_edge_less_than_the_plain_mean() -> None:
    flow, region = contact(0.01, 40), Region.circle(100, 100, 44)
    plain = mean_divergence(flow, region.polygon_px)
    fitted = np.trace(fit_field(flow, region).matrix)
    assert plain < 0.0175 < 0.0185 < fitted < 0.02


def test_fit_does_not_jump_as_the_region_grows() -> None:
    flow = contact(0.01, 40)
    radii = np.arange(36, 44, 0.1)
    traces = np.array([np.trace(fit_field(flow, Region.circle(100, 100, radius)).matrix) for radius in radii])
    assert np.abs(np.diff(traces, 2)).max() < 0.005 * 0.02
