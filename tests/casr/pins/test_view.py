"""Thresholds that follow pitch, pixel size and noise."""

from __future__ import annotations

import numpy as np
import pytest

from casr.camera import Camera
from casr.pins import PinSettings, PinTracker, detect_pins, match_pins
from casr.pins.pitch import guess_pitch_px
from casr.pins.view import line_noise, noisy_share
from emg2vsa.worlds.tactile import TACTIP_127, Appearance, Skin, draw_surface, drawn, exposed

DENSE = Skin(rings=10, pitch_px=12.4, pin_radius_px=2.8)


def frame(scale=1.0, noise_grey=2.0, skin=TACTIP_127, size=(300, 300), moved_px=0.0, seed=5):
    """True pins and the frame of a sensor whose image is ``scale`` times as large."""
    height, width = size
    camera = Camera(width_px=width, height_px=height, cx_px=(width - 1) / 2, cy_px=(height - 1) / 2)
    lengths = ("pitch_px", "pin_radius_px", "edge_px", "mask_radius_px")
    large = Skin(rings=skin.rings, **{name: scale * getattr(skin, name) for name in lengths})
    surface = draw_surface(Appearance(), large, camera, np.random.default_rng(1), np.random.default_rng(2))
    pins = large.pins_px((camera.cx_px, camera.cy_px)) + moved_px
    return pins, exposed(drawn(pins, surface, large), noise_grey, np.random.default_rng(seed))


@pytest.mark.parametrize(
    ("skin", "scale", "size"),
    [
        (TACTIP_127, 0.5, (150, 150)),
        (TACTIP_127, 1.6, (480, 640)),
        (TACTIP_127, 10, (3000, 4000)),
        (DENSE, 1, (300, 300)),
        (DENSE, 3.2, (960, 1280)),
        (DENSE, 10, (3000, 4000)),
    ],
)
def test_every_pin_at_every_size(scale, size, skin):
    true_px, image = frame(scale, skin=skin, size=size)
    pins = detect_pins(image)
    rows, found = match_pins(true_px, pins.centroids_px, max_distance_px=2 * scale)
    assert len(rows) == len(true_px) == len(pins)
    errors = np.hypot(*(pins.centroids_px[found] - true_px[rows]).T)
    assert np.sqrt((errors**2).mean()) < (0.03 if scale > 0.5 else 0.06)
    assert np.sqrt(pins.area_px.mean() / np.pi) == pytest.approx(scale * skin.pin_radius_px, rel=0.15)


@pytest.mark.parametrize("noise_grey", [8, 15, 25])
@pytest.mark.parametrize("skin", [TACTIP_127, DENSE], ids=["127", "331"])
def test_every_pin_in_noise(noise_grey, skin):
    true_px, image = frame(noise_grey=noise_grey, skin=skin)
    pins = detect_pins(image)
    rows, found = match_pins(true_px, pins.centroids_px, max_distance_px=2)
    assert len(rows) == len(true_px) == len(pins)
    assert np.sqrt(((pins.centroids_px[found] - true_px[rows]) ** 2).sum(axis=1).mean()) < 0.01 * noise_grey


def test_a_large_frame_is_tracked_in_its_own_pixels():
    true_px, first = frame(10, size=(3000, 4000))
    tracker = PinTracker()
    start_px = tracker.start(first).centroids_px
    rows, ids = match_pins(true_px, start_px, max_distance_px=20)
    assert len(rows) == 127
    assert tracker.pitch_px == pytest.approx(200, rel=0.02)
    moved_px, second = frame(10, size=(3000, 4000), moved_px=37.3)
    assert np.abs(tracker.step(second)[ids] - moved_px[rows]).max() < 0.2


@pytest.mark.parametrize(("scale", "size"), [(0.5, (150, 150)), (1, (300, 300)), (7, (2200, 2100))])
def test_pitch_is_guessed_from_what_repeats(scale, size):
    for noise_grey in (2, 15):
        assert guess_pitch_px(frame(scale, noise_grey, size=size)[1]) == pytest.approx(20 * scale, rel=0.06)


def test_where_nothing_repeats_no_pitch_is_guessed():
    noise = np.random.default_rng(0).normal(80, 15, (300, 300)).clip(0, 255).astype(np.uint8)
    assert guess_pitch_px(noise) is None
    assert guess_pitch_px(noise[:10, :10]) is None


@pytest.mark.parametrize("noise_grey", [0.0, 4.0, 10.0])
def test_noise_is_seen_beside_the_edges_of_pins(noise_grey):
    """A seventh too low: the skin is dark at its rim, and grey levels end at black."""
    seen = [np.median(line_noise(frame(noise_grey=noise_grey, seed=seed)[1])) for seed in range(6)]
    assert np.mean(seen) == pytest.approx(6 / 7 * noise_grey, rel=0.05)


def test_what_is_asked_for_is_taken():
    _, image = frame()
    assert len(detect_pins(image, PinSettings(pitch_px=20.0))) == 127
    assert len(detect_pins(image, PinSettings(min_area_px=40))) == 127
    with pytest.raises(Exception, match="bright blobs"):
        detect_pins(image, PinSettings(min_area_px=400))
    with pytest.raises(Exception, match="bright blobs"):
        detect_pins(image, PinSettings(contrast=200.0))


@pytest.mark.parametrize("width", [64, 65, 2])
def test_the_share_of_noisy_lines_is_that_of_their_medians(width):
    rng = np.random.default_rng(2)
    for _ in range(20):
        # from clean to noisy lines, and many equal values, so that medians lie on either side of and at the limit
        grey = np.clip(128 + rng.normal(size=(70, width)) * np.linspace(0, 20, 70)[:, None], 0, 255).astype(np.uint8)
        for most in (0.0, 2.0, float(np.median(line_noise(grey))), 8.0):
            assert noisy_share(grey, most) == np.mean(line_noise(grey) > most)
