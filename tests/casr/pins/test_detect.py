from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from casr.errors import ImageError, PinsError, SettingError
from casr.pins import PinSettings, detect_pins, match_pins

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


@pytest.mark.parametrize(
    ("frame", "hint"),
    [
        (np.zeros((300, 300), np.uint8), "uniform"),
        (np.full((300, 300), 255, np.uint8), "uniform"),
        (np.full((1, 1), 90, np.uint8), "uniform"),
        (np.random.default_rng(0).uniform(0, 1, (300, 300)), "not to 1"),
        (np.kron(np.eye(4), np.full((40, 40), 200.0)), "--pitch"),
    ],
    ids=["black", "saturated", "one pixel", "zero to one", "no pins"],
)
def test_a_frame_without_pins_says_what_to_do(frame, hint):
    with pytest.raises(PinsError, match=hint):
        detect_pins(frame)


def test_a_frame_full_of_specks_says_so():
    frame = np.zeros((600, 600), np.uint8)
    frame[5:-5:8, 5:-5:8] = 255
    with pytest.raises(PinsError, match="too noisy"):
        detect_pins(cv2.dilate(frame, np.ones((3, 3), np.uint8)))


def test_not_finite_is_an_image_error(draw, hexagon_px):
    frame = draw(hexagon_px).astype(float)
    frame[3, 4] = np.nan
    with pytest.raises(ImageError):
        detect_pins(frame)


@pytest.mark.parametrize(
    "wrong",
    [
        {"block_px": 30},
        {"contrast": 0},
        {"min_area_px": 0},
        {"area_ratio": (1.2, 2)},
        {"max_aspect": 0.5},
        {"pitch_px": 2.0},
        {"pitch_px": float("inf")},
        {"expect_pins": 2},
    ],
)
def test_senseless_settings_are_refused(wrong):
    with pytest.raises(SettingError, match=next(iter(wrong))):
        PinSettings(**wrong)


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
