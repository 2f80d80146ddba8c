"""Dense Horn-Schunck flow: accuracy on known motion, and every input it must survive."""

from __future__ import annotations

import subprocess
import sys

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.tactile.flow_pairs import contact_pair
from benchmarks.tactile.ours import NATURAL_IMAGES
from casr.errors import ImageError, SettingError
from casr.flow.divergence import divergence
from casr.flow.horn_schunck import HornSchunck, HornSchunckSettings, horn_schunck

CORE_PX = 64.0


def _core_error(pair, **options):
    """Mean divergence over the core against the truth, relative."""
    flow = horn_schunck(pair.first, pair.second, **options)
    y, x = np.mgrid[: flow.shape[0], : flow.shape[1]]
    core = np.hypot(x - pair.contact.centre_px[0], y - pair.contact.centre_px[1]) < CORE_PX
    return divergence(flow)[core].mean() / pair.divergence - 1


@pytest.mark.parametrize(("rim_motion_px", "spread"), [(0.25, 0.03), (1.0, 0.01), (3.0, 0.005), (6.0, 0.005)])
def test_divergence_of_a_contact_within_one_per_cent(rim_motion_px, spread):
    errors = [_core_error(contact_pair(rim_motion_px, seed)) for seed in range(6)]
    assert abs(np.mean(errors)) < 0.01
    assert np.std(errors) < spread


def test_region_of_interest_gives_the_same_core_and_nothing_far_away():
    pair = contact_pair(1.0, 1)
    box = (86, 86, 214, 214)
    assert _core_error(pair, roi=box) == pytest.approx(_core_error(pair), abs=1e-3)
    flow = horn_schunck(pair.first, pair.second, roi=box)
    assert flow.shape == (300, 300, 2)
    assert np.isfinite(flow[86:214, 86:214]).all()
    assert np.isnan(flow[:40]).all()
    assert np.isnan(flow[:, -40:]).all()


def test_a_sequence_gives_the_flow_of_its_pairs():
    frames = [contact_pair(motion, 2).second for motion in (0.5, 1.0, 6.0, 6.5)]
    boxes = [None, (100, 90, 200, 200), (100, 90, 200, 200)]
    engine = HornSchunck()
    engine.start(frames[0])
    for before, after, box in zip(frames, frames[1:], boxes, strict=False):
        np.testing.assert_array_equal(engine.step(after, box), horn_schunck(before, after, roi=box))


def test_a_camera_may_reuse_its_memory():
    pair = contact_pair(1.0)
    memory = pair.first.copy()
    engine = HornSchunck()
    engine.start(memory)
    memory[:] = pair.second
    np.testing.assert_array_equal(engine.step(memory), horn_schunck(pair.first, pair.second))


@pytest.mark.parametrize("precision", ["single", "double"])
@pytest.mark.parametrize("preset", [HornSchunckSettings(), NATURAL_IMAGES])
def test_identical_frames_give_exactly_zero(precision, preset):
    image = np.random.default_rng(0).integers(0, 256, (70, 83), dtype=np.uint8)
    chosen = HornSchunckSettings(**{**vars(preset), "precision": precision})
    assert not horn_schunck(image, image.copy(), settings=chosen).any()


@pytest.mark.parametrize("level", [0, 20, 255])
def test_constant_frames_give_exactly_zero(level):
    image = np.full((64, 75), level, np.uint8)
    assert not horn_schunck(image, image).any()
    assert np.abs(horn_schunck(image, np.full_like(image, 128))).max() < 1e-3


@pytest.mark.parametrize("shape", [(1, 1), (2, 1), (1, 2), (2, 2), (3, 5), (5, 3), (1, 40), (40, 1), (9, 9), (31, 33)])
@pytest.mark.parametrize("cell_px", [1, 2, 4])
def test_tiny_frames(shape, cell_px):
    rng = np.random.default_rng(1)
    first, second = rng.integers(0, 256, (2, *shape), dtype=np.uint8)
    for limit in (0.0, 3.5):
        chosen = HornSchunckSettings(cell_px=cell_px, warp_above_px=limit)
        flow = horn_schunck(first, second, settings=chosen)
        assert flow.shape == (*shape, 2)
        assert np.isfinite(flow).all()
    assert np.isfinite(horn_schunck(first, second, settings=NATURAL_IMAGES)).all()


@pytest.mark.parametrize("alpha", [1e-6, 1e-3, 1.0, 1e3, 1e6])
@pytest.mark.parametrize("precision", ["single", "double"])
def test_extreme_alpha_stays_finite(alpha, precision):
    pair = contact_pair(1.0)
    box = slice(100, 164), slice(90, 170)
    for limit in (0.0, 3.5):
        chosen = HornSchunckSettings(alpha=alpha, precision=precision, warp_above_px=limit)
        assert np.isfinite(horn_schunck(pair.first[box], pair.second[box], settings=chosen)).all()


def test_saturated_frames_stay_finite():
    rng = np.random.default_rng(2)
    first, second = (255 * rng.integers(0, 2, (2, 90, 77))).astype(np.uint8)
    assert np.isfinite(horn_schunck(first, second)).all()


def test_precision_follows_alpha():
    pair = contact_pair(1.0, 3)
    for alpha, dtype in ((1.0, np.float32), (0.5, np.float64)):
        assert horn_schunck(pair.first, pair.second, settings=HornSchunckSettings(alpha=alpha)).dtype == dtype


def test_single_precision_is_enough():
    pair = contact_pair(1.0)
    single = horn_schunck(pair.first, pair.second)
    double = horn_schunck(pair.first, pair.second, settings=HornSchunckSettings(precision="double"))
    assert (single.dtype, double.dtype) == (np.float32, np.float64)
    assert np.abs(single - double).max() < 1e-5


def test_types_and_layouts_are_one_image():
    pair = contact_pair(1.0)
    wanted = horn_schunck(pair.first, pair.second)
    wide = np.zeros((600, 600), np.uint8)
    wide[::2, ::2] = pair.first
    colour = cv2.cvtColor(pair.first, cv2.COLOR_GRAY2BGR)
    sixteen = pair.first.astype(np.uint16) * 257
    for first in (wide[::2, ::2], np.asfortranarray(pair.first), colour, sixteen, pair.first.astype(np.float64)):
        np.testing.assert_allclose(horn_schunck(first, pair.second), wanted, atol=1e-5)


@settings(max_examples=15, deadline=None)
@given(u=st.floats(-2, 2), v=st.floats(-2, 2), seed=st.integers(0, 1000))
def test_translation_of_a_texture(u, v, seed):
    rng = np.random.default_rng(seed)
    fine = cv2.GaussianBlur(rng.normal(0, 1, (128, 128)), (0, 0), 3)
    fine = 128 + 40 * fine / fine.std()
    moved = np.fft.ifft2(
        np.fft.fft2(fine) * np.exp(-2j * np.pi * (u * np.fft.fftfreq(128) + v * np.fft.fftfreq(128)[:, None]))
    ).real
    flow = horn_schunck(fine, moved, settings=HornSchunckSettings(warp_above_px=0, warps=2))
    np.testing.assert_allclose(flow[20:-20, 20:-20].mean(axis=(0, 1)), (u, v), atol=0.02)


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 100))
def test_turned_frames_turn_the_flow(seed):
    pair = contact_pair(1.0, seed)
    flow = horn_schunck(pair.first, pair.second)
    turned = horn_schunck(np.rot90(pair.first).copy(), np.rot90(pair.second).copy())
    # rot90 takes (u, v) to (v, -u); what one V-cycle leaves over depends on the order of the sweep
    wanted = np.rot90(np.stack([flow[..., 1], -flow[..., 0]], axis=-1))
    assert np.abs(turned - wanted).mean() < 0.01


def test_flow_of_a_third_of_the_pitch_is_found_by_the_pyramid():
    still = contact_pair(0.0).first
    moved = np.roll(still, 7, axis=1)
    flow = horn_schunck(still, moved)[100:200, 100:200]
    np.testing.assert_allclose(np.median(flow, axis=(0, 1)), (7, 0), atol=0.05)


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (np.zeros((8, 9), np.uint8), np.zeros((9, 8), np.uint8)),
        (np.full((8, 8), np.nan), np.zeros((8, 8))),
        (np.zeros((8, 8)), np.full((8, 8), np.inf)),
        (np.zeros((0, 8)), np.zeros((0, 8))),
        (np.zeros(8), np.zeros(8)),
    ],
)
def test_unusable_frames_are_refused(first, second):
    with pytest.raises(ImageError):
        horn_schunck(first, second)


def test_a_step_needs_a_start():
    with pytest.raises(ImageError, match="no first frame"):
        HornSchunck().step(np.zeros((8, 8)))


def test_a_region_outside_is_refused():
    image = np.zeros((40, 40), np.uint8)
    with pytest.raises(ImageError, match="region"):
        horn_schunck(image, image, roi=(50, 0, 60, 10))


@pytest.mark.parametrize(
    "wrong",
    [
        {"alpha": 0.0},
        {"alpha": float("nan")},
        {"presmoothing_px": -1.0},
        {"cell_px": 3},
        {"sweeps": 0},
        {"cycles": 0},
        {"warp_above_px": -1.0},
        {"pyramid_levels": 0},
        {"warps": 0},
        {"median_px": 4},
        {"support_px": -1},
        {"precision": "half"},
    ],
)
def test_settings_out_of_range_are_refused(wrong):
    with pytest.raises(SettingError, match=next(iter(wrong))):
        HornSchunckSettings(**wrong)


def test_settings_load_without_numba():
    code = "import sys, casr.flow.step, casr.flow.estimate; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
