"""Dense fields: divergence and growth of flows that are known, OpenCV's DIS, and the mean over the whole image."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.tactile.flow_pairs import contact_pair
from casr.flow.dense_engine import PRESETS, Dis, dis_flow, divergence, fit_field, mean_divergence, region_mask
from casr.flow.estimate import FlowSettings, FlowTracker
from casr.flow.region import Region
from casr.frames import FrameSequence
from casr.scoring import Score, ScoreSettings, score


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


REGION = Region.circle(100, 100, 30)


def textured(growth: float) -> np.ndarray:
    """A random texture, and the same larger by a factor about the middle."""
    rng = np.random.default_rng(4)
    image = cv2.GaussianBlur(rng.normal(size=(200, 200)), (0, 0), 3)
    image = np.clip(128 + 60 * image / image.std(), 0, 255).astype(np.uint8)
    middle = cv2.getRotationMatrix2D((99.5, 99.5), 0, growth)
    return cv2.warpAffine(image, middle, (200, 200), flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT)


@pytest.mark.parametrize("engine", ["dis", "horn-schunck"])
def test_a_stretched_image_has_the_divergence_of_its_stretch(engine: str) -> None:
    if engine == "horn-schunck":
        pytest.importorskip("numba")
    tracker = FlowTracker(FlowSettings(engine=engine), whole_image=True)
    tracker.start(textured(1.0), REGION)
    step = tracker.step(textured(1.01))
    assert step.divergence == pytest.approx(0.02, rel=0.15)
    assert step.log_growth == step.divergence
    assert step.n == 200 * 200
    assert "whole image" in step.notes[0]
    assert step.region is REGION


def test_it_is_the_plain_mean_of_the_flow() -> None:
    first, second = textured(1.0), textured(1.02)
    tracker = FlowTracker(FlowSettings(engine="dis"), whole_image=True)
    tracker.start(first, REGION)
    assert tracker.step(second).divergence == pytest.approx(float(divergence(dis_flow(first, second)).mean()), rel=1e-6)
    assert tracker.step(second).divergence == 0.0, "frames that are the same"


def test_a_press_by_the_whole_image_keeps_its_initial_area(soft: tuple[FrameSequence, Score]) -> None:
    sequence, _ = soft
    whole, core = (
        score(sequence, ScoreSettings(quantity="skin", region=region, flow=FlowSettings(engine="dis")))
        for region in ("image", None)
    )
    assert whole.area[0] == core.area[0]
    pairs = zip(whole.frames[:-1], whole.frames[1:], strict=True)
    by_hand = [float(divergence(dis_flow(sequence[a], sequence[b])).mean()) for a, b in pairs]
    assert whole.divergence == pytest.approx(by_hand, abs=2e-5)
    assert any("whole image" in note for note in whole.notes)
    assert whole.settings.region == "image"
    assert whole.to_dict()["settings"]["region"] == "image"
