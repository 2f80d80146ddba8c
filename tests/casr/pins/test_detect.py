"""Pins of one frame, and thresholds that follow pitch, pixel size and noise."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from casr.camera import Camera
from casr.pins import PinSettings, PinTracker, detect_pins, match_pins
from casr.pins.view import guess_pitch_px, line_noise, noisy_share
from emg2vsa.worlds.tactile import TACTIP_127, Appearance, Skin, draw_surface, drawn, exposed

SharedData = Callable[[str], Path]


def errors_px(true_px, found_px):
    true_rows, found_rows = match_pins(true_px, found_px, max_distance_px=3)
    assert len(true_rows) == len(found_px)
    return found_px[found_rows] - true_px[true_rows]


def test_every_pin_is_found_to_two_hundredths_of_a_pixel(draw, hexagon_px):
    errors = np.concatenate([errors_px(hexagon_px, detect_pins(draw(hexagon_px)).centroids_px) for _ in range(5)])
    assert len(errors) == 5 * 127
    assert np.sqrt((errors**2).sum(axis=1).mean()) < 0.02
    assert np.abs(errors.mean(axis=0)).max() < 0.002


def test_area_is_that_of_the_pin(draw, hexagon_px):
    assert detect_pins(draw(hexagon_px)).area_px.mean() == pytest.approx(np.pi * 4.5**2, rel=0.1)


def test_reflections_brighter_or_larger_than_pins_are_left_out(draw, hexagon_px):
    frame = draw(hexagon_px)
    cv2.circle(frame, (149, 30), 3, 255, -1)  # small and bright, away from the pins
    cv2.circle(frame, (30, 60), 14, 150, -1)  # large and as bright as a pin
    pins = detect_pins(frame)
    errors_px(hexagon_px, pins.centroids_px)
    assert len(pins) == 127
    assert any("glare" in note for note in pins.notes)


def test_touching_pins_are_taken_apart(draw, hexagon_px):
    pushed = hexagon_px.copy()
    other = np.hypot(*(pushed - pushed[60]).T).argsort()[1]
    pushed[other] = pushed[60] + (9.0, 1.0)
    pins = detect_pins(draw(pushed))
    true_rows, found_rows = match_pins(pushed, pins.centroids_px, max_distance_px=3)
    assert len(true_rows) == len(pins) == 127
    errors = np.hypot(*(pins.centroids_px[found_rows] - pushed[true_rows]).T)
    assert np.sort(errors)[-3] < 0.1  # all but the two that touch
    assert errors.max() < 0.7
    assert "1 blobs were touching pins and were split" in pins.notes
    whole = detect_pins(draw(pushed), PinSettings(most_touching=1, area_ratio=(0.3, 1.5)))
    assert len(whole) == 125


def test_a_bright_pin_and_a_dim_side_of_the_image_are_no_glare(draw, hexagon_px):
    light = np.linspace(0.5, 1.3, 300)
    frame = np.clip(draw(hexagon_px) * light, 0, 255).astype(np.uint8)
    assert len(detect_pins(frame)) == 127


def test_background_that_rises_across_the_image_moves_no_pin_far(draw, hexagon_px):
    frame = np.clip(draw(hexagon_px) + np.linspace(0, 80, 300), 0, 255).astype(np.uint8)
    errors = errors_px(hexagon_px, detect_pins(frame).centroids_px)
    assert np.sqrt((errors**2).sum(axis=1).mean()) < 0.05


@pytest.mark.parametrize(
    "change",
    [
        lambda frame: frame.astype(np.float64),
        lambda frame: frame.astype(np.uint16) * 257,
        lambda frame: np.repeat(frame[:, :, None], 3, axis=2),
        lambda frame: np.repeat(frame, 2, axis=1)[:, ::2],
        np.asfortranarray,
    ],
    ids=["float", "16 bit", "colour", "not contiguous", "column order"],
)
def test_the_same_frame_in_another_form_gives_the_same_pins(draw, hexagon_px, change):
    frame = draw(hexagon_px)
    expected = detect_pins(frame)
    found = detect_pins(change(frame))
    # the mean of the surroundings is rounded in 8 bits only, which may turn a pixel at a blob's edge
    assert found.centroids_px == pytest.approx(expected.centroids_px, abs=0.005)


def test_dark_pins_are_found_when_asked_for(draw, hexagon_px):
    frame = 255 - draw(hexagon_px, noise_grey=0)
    assert detect_pins(frame, PinSettings(dark_pins=True)).centroids_px == pytest.approx(
        detect_pins(255 - frame).centroids_px
    )


def test_binary_frames_are_taken_as_they_are(draw, hexagon_px):
    binary = draw(hexagon_px, noise_grey=0) > 80
    errors = errors_px(hexagon_px, detect_pins(binary).centroids_px)
    assert len(errors) == 127
    assert np.sqrt((errors**2).mean()) < 0.15


def counts(folder: Path, pattern: str) -> np.ndarray:
    paths = sorted(folder.glob(pattern))
    assert paths
    return np.array([len(detect_pins(cv2.imread(str(path), cv2.IMREAD_UNCHANGED))) for path in paths])


def test_real_flat_press(shared_data: SharedData):
    found = counts(shared_data("tactile/tactip127_flat_press_640x480"), "*.png")
    assert len(found) == 91
    assert found.min() >= 126
    assert found.max() == 127


def test_real_shapes(shared_data: SharedData):
    found = counts(shared_data("tactile/tactip127_shapes_300x300"), "*/*.png")
    assert found.min() >= 121
    assert found.max() <= 128
    assert np.median(found) == 127


def test_real_surface_inside_a_bright_ring(shared_data: SharedData):
    found = counts(shared_data("tactile/tactip127_surface2d_bw_256x256"), "*.png")
    assert set(found) <= {127, 128}
    assert np.mean(found == 127) > 0.9


def test_real_colour_frames_with_lamps_around(shared_data: SharedData):
    found = counts(shared_data("tactile/tactip331_raw_640x480"), "*.png")
    assert np.mean(np.abs(found - 331) <= 2) >= 0.9


def test_blobs_too_close_to_see_between_still_have_a_place():
    frame = np.zeros((60, 60), np.uint8)
    frame[10:50:4, 10:50:4] = 255
    pins = detect_pins(cv2.dilate(frame, np.ones((3, 3), np.uint8)), PinSettings(block_px=59, pitch_px=4))
    assert len(pins) == 100
    assert np.isfinite(pins.centroids_px).all()


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
