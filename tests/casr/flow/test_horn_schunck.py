"""Dense Horn-Schunck flow: accuracy on known motion, and every input it must survive."""

from __future__ import annotations

import subprocess
import sys
from functools import cache

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.tactile import flow_pairs
from benchmarks.tactile.methods import NATURAL_IMAGES
from casr.flow.dense_engine import divergence
from casr.flow.horn_schunck import HornSchunck, HornSchunckSettings, horn_schunck

CORE_PX = 64.0
contact_pair = cache(flow_pairs.contact_pair)


def _core_error(pair, **options):
    """Mean divergence over the core against the truth, relative."""
    flow = horn_schunck(pair.first, pair.second, **options)
    y, x = np.mgrid[: flow.shape[0], : flow.shape[1]]
    core = np.hypot(x - pair.contact.centre_px[0], y - pair.contact.centre_px[1]) < CORE_PX
    return divergence(flow)[core].mean() / pair.divergence - 1


@pytest.mark.parametrize(
    ("rim_motion_px", "spread", "pairs"),
    [pytest.param(0.25, 0.03, 48, marks=pytest.mark.slow), (1.0, 0.01, 12), (3.0, 0.005, 6), (6.0, 0.005, 6)],
)
def test_divergence_of_a_contact_within_one_per_cent(rim_motion_px, spread, pairs):
    """So many pairs that the mean is known to 0.3 %."""
    errors = [_core_error(contact_pair(rim_motion_px, seed)) for seed in range(pairs)]
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


def _shifted_texture(shift_px, seed=0, *, blur_px=3.0, contrast_grey=40, side=300):
    """Two views of one random texture; the second shows it shift_px further right."""
    fine = cv2.GaussianBlur(np.random.default_rng(seed).normal(0, 1, (side, side + 80)), (0, 0), blur_px)
    grey = np.clip(np.rint(128 + contrast_grey * fine / fine.std()), 0, 255).astype(np.uint8)
    return grey[:, 40 : 40 + side], grey[:, 40 - shift_px : 40 - shift_px + side]


def _step(first, second, settings=None, roi=None):
    engine = HornSchunck(settings)
    engine.start(first)
    return engine.step(second, roi), engine.notes


@pytest.mark.parametrize("shift_px", [6, 15, 25])
@pytest.mark.parametrize("blur_px", [1.0, 3.0])
def test_the_pyramid_grows_with_the_motion(shift_px, blur_px):
    first, second = _shifted_texture(shift_px, blur_px=blur_px)
    flow, notes = _step(first, second)
    error_px = np.hypot(flow[..., 0] - shift_px, flow[..., 1])[30:-30, 30:-30]
    assert error_px.mean() < 0.2
    assert not notes


def test_a_region_too_small_for_the_motion_is_found_on_the_whole_frame():
    flow, notes = _step(*_shifted_texture(15), roi=(120, 120, 180, 180))
    np.testing.assert_allclose(np.median(flow[120:180, 120:180], axis=(0, 1)), (15, 0), atol=0.05)
    assert not notes


@pytest.mark.parametrize("roi", [None, (130, 130, 170, 170)])
def test_a_weak_texture_whose_motion_looks_short_is_found_too(roi):
    first, second = _shifted_texture(15, blur_px=1.0, contrast_grey=15)
    once, _ = _step(first, second, HornSchunckSettings(warp_above_px=np.inf))
    assert np.abs(once).max() < HornSchunckSettings().warp_above_px
    flow, notes = _step(first, second, roi=roi)
    np.testing.assert_allclose(np.median(flow[130:170, 130:170], axis=(0, 1)), (15, 0), atol=0.1)
    assert not notes


def test_a_pyramid_fixed_too_low_is_said():
    flow, notes = _step(*_shifted_texture(15), HornSchunckSettings(pyramid_levels=2))
    assert abs(np.median(flow[30:-30, 30:-30, 0]) - 15) > 5
    assert any("pyramid_levels 2 is too few" in note for note in notes)


def test_frames_that_no_pyramid_brings_together_are_said():
    first, second = _shifted_texture(0, 1)[0], _shifted_texture(0, 2)[0]
    assert any("are the frames one press" in note for note in _step(first, second)[1])


def test_something_fast_before_a_slow_background():
    rng = np.random.default_rng(3)
    behind, front = (
        cv2.normalize(sum(width * cv2.GaussianBlur(noise, (0, 0), width) for width in (1.5, 4, 12)), None, 0, 255, 32)
        for noise in rng.normal(0, 1, (2, 300, 380))
    )
    x, y = np.meshgrid(np.arange(320), np.arange(240))

    def frame(slow_px, fast_px):
        shown = (np.abs(x - fast_px - 140) < 60) & (np.abs(y - 120) < 70)
        views = (texture[30:270, 30 - px : 350 - px] for texture, px in ((front, fast_px), (behind, slow_px)))
        return np.where(shown, *views).astype(np.uint8), shown

    (first, fast), (second, _) = frame(0, 0), frame(1, 15)
    flow, notes = _step(first, second)
    error_px = np.hypot(flow[..., 0] - np.where(fast, 15, 1), flow[..., 1])[20:-20, 20:-20]
    two_levels, _ = _step(first, second, HornSchunckSettings(pyramid_levels=2))
    assert error_px.mean() < 1.2
    assert np.abs(two_levels[..., 0] - np.where(fast, 15, 1))[20:-20, 20:-20].mean() > 2.5
    assert not notes


@pytest.mark.parametrize(
    ("alpha", "said"), [(1e-4, "small"), (1.0, "small"), (10.0, ""), (30.0, ""), (300.0, "large"), (1e6, "large")]
)
def test_a_useless_alpha_is_said_once(alpha, said):
    pair = contact_pair(1.0)
    engine = HornSchunck(HornSchunckSettings(alpha=alpha, precision="double"))
    engine.start(pair.first)
    engine.step(pair.second)
    about = [note for note in engine.notes if note.startswith("alpha")]
    assert bool(about) == bool(said)
    assert all(f"too {said}" in note for note in about)
    engine.step(pair.first)
    assert not [note for note in engine.notes if note.startswith("alpha")]


def test_a_flow_longer_than_the_frame_is_said():
    pair = contact_pair(1.0)
    flow, notes = _step(pair.first, pair.second, HornSchunckSettings(alpha=1e-4))
    assert np.abs(flow).max() > 300
    assert any("longer than the frame" in note for note in notes)


def test_settings_load_without_numba():
    code = "import sys, casr.flow.step, casr.flow.estimate; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
