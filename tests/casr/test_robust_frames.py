"""Presses with bad frames, knocks, lost pins, a force that goes back, and other sensors."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.tactile.press_scores import ArrayFrames
from casr.camera import Camera
from casr.contact_area import initial_area
from casr.errors import NoContactError, PinsError
from casr.flow.estimate import FlowSettings, FlowTracker
from casr.flow.region import Region
from casr.frames import FrameSequence
from casr.pins import Pins, PinSettings
from casr.scoring import Score, ScoreSettings, score
from casr.specimens import SPECIMENS
from casr.stream import SKIPPED, StreamScorer
from emg2vsa.worlds.tactile import ContactWorld, PressSettings, SimulatedFrames, Skin, TimelineSettings, simulate_press

Images = NDArray[np.uint8]
SKIN = ScoreSettings(quantity="skin")
Frames = tuple[Images, NDArray[np.float64]]


@cache
def press(loading_s: float = 1.5) -> Frames:
    """Frames from rest to a little after the peak, and their force."""
    settings = PressSettings(
        stiffness_n_per_mm=SPECIMENS["S3"], world=ContactWorld(), timeline=TimelineSettings(loading_s=loading_s)
    )
    made = simulate_press(settings)
    last = int(made.truth.loading_frames[-1]) + 3
    return np.stack([made.frames.read(index) for index in range(last)]), made.sequence().force_n[:last]


def scored(images: Images, force: NDArray[np.float64], settings: ScoreSettings | None = None) -> Score:
    return score(FrameSequence(ArrayFrames(images), None, force), settings or SKIN)


@cache
def clean_score(border_px: int = 0) -> Score:
    """Of the press as it is, its images with a black border."""
    images, force = press()
    return scored(np.pad(images, ((0, 0), (border_px, border_px), (border_px, border_px))), force)


def streamed(images: Images, force: NDArray[np.float64]) -> Score:
    stream = StreamScorer(settings=SKIN)
    for image, f in zip(images, force, strict=True):
        stream.push(image, float(f))
    return stream.finish()


def black(image: Images) -> Images:
    return np.zeros_like(image)


def torn(image: Images) -> Images:
    whole = image.copy()
    whole[140:] = np.roll(whole[140:], 13, axis=1)
    return whole


def half_noise(image: Images) -> Images:
    noisy = image.copy()
    noisy[150:] = np.random.default_rng(0).integers(0, 256, noisy[150:].shape)
    return noisy


@pytest.mark.parametrize("spoil", [black, torn, half_noise])
def test_a_bad_frame_is_left_out_and_said(spoil: Callable[[Images], Images]) -> None:
    images, force = press()
    clean = clean_score()
    bad = images.copy()
    hit = [int(clean.frames[k]) for k in (6, 15, 16, len(clean.frames) - 1)]
    for index in hit:
        bad[index] = spoil(images[index])
    for found in (scored(bad, force), streamed(bad, force)):
        assert found.frames.tolist() == [index for index in clean.frames.tolist() if index not in hit]
        assert len(found.area) == len(found.regions) == len(found.frames) == len(found.log_growth) + 1
        kept = np.isin(clean.frames, found.frames)
        assert found.force_n.tolist() == clean.force_n[kept].tolist()
        np.testing.assert_allclose(found.area, clean.area[kept], rtol=2e-4)
        assert found.rate.value == pytest.approx(clean.rate.value, rel=2e-3)
        assert any(note.startswith(f"frames {', '.join(map(str, hit))} are skipped") for note in found.notes)


def test_a_bad_first_contact_leaves_the_next_frame_to_be_it() -> None:
    images, force = press()
    clean = clean_score()
    bad = images.copy()
    bad[clean.frames[0]] = 0
    for found in (scored(bad, force), streamed(bad, force)):
        assert found.frames.tolist() == clean.frames[1:].tolist()
        np.testing.assert_allclose(found.area, clean.area[1:], rtol=0.02)


def test_three_bad_frames_in_a_row_end_the_press() -> None:
    images, force = press()
    first = int(clean_score().frames[0])
    bad = images.copy()
    bad[first + 10 : first + 13] = 0
    with pytest.raises(PinsError, match=rf"frame {first + 12}, pins: .*in 3 frames in a row"):
        scored(bad, force)
    with pytest.raises(PinsError, match="in 3 frames in a row"):
        streamed(bad, force)


def test_the_stream_says_which_frame_it_skips_and_goes_on() -> None:
    images, force = press()
    bad = images.copy()
    bad[30] = 0
    stream = StreamScorer(settings=SKIN)
    states = [stream.push(image, float(f)) for image, f in zip(bad[:40], force, strict=False)]
    assert (states[30].area, states[30].notes) == (None, (SKIPPED,))
    assert states[31].area > states[29].area


@pytest.mark.parametrize("knock_px", [(40, 0), (20, 35), (13, -31)])
def test_a_knock_of_the_camera_is_taken_out(knock_px: tuple[int, int]) -> None:
    images, force = press()
    wide = np.pad(images, ((0, 0), (60, 60), (60, 60)))
    clean = clean_score(60)
    knocked = wide.copy()
    middle = int(clean.frames[20])
    knocked[middle:] = np.roll(wide[middle:], knock_px[::-1], axis=(1, 2))
    found = scored(knocked, force)
    assert [note for note in found.notes if "knock of the camera" in note] == [
        note for note in found.notes if note.startswith(f"frame {middle}: ")
    ]
    assert len(found.notes) == len(clean.notes) + 1
    np.testing.assert_allclose(found.area, clean.area, rtol=1e-3)
    moved = found.regions[-1] - clean.regions[-1]
    np.testing.assert_allclose(moved, np.broadcast_to(knock_px, moved.shape), atol=0.1)


def without_pin(image: Images, at_px: NDArray[np.float64]) -> Images:
    return np.asarray(cv2.circle(image.copy(), (round(at_px[0]), round(at_px[1])), 9, 20, -1))


def test_one_lost_pin_of_three_does_not_end_a_press() -> None:
    images, force = press(3.0)
    clean = scored(images, force)
    start = clean.frames[0]
    pins = clean.contact_px
    nearest = np.hypot(*(pins - 150).T).argsort()
    a, b = pins[nearest[:2]]
    third = pins[min(nearest[2:], key=lambda row: float(np.hypot(*(pins[row] - a)) + np.hypot(*(pins[row] - b))))]
    x, y = (a + b + third) / 3
    settings = ScoreSettings(quantity="skin", region=Region.circle(float(x), float(y), 14.0))
    whole = scored(images, force, settings)
    assert whole.initial.selected.size == 3
    lost = whole.initial.selected[0]
    dirty = images.copy()
    for index in range(start + 5, start + 12):
        dirty[index] = without_pin(
            images[index], pins[lost] + (pins[lost] - pins.mean(axis=0)) * 0.02 * (index - start)
        )
    found = scored(dirty, force, settings)
    assert any("fewer than 3 of the region's pins are seen: those just outside it help" in note for note in found.notes)
    assert len(found.frames) == len(whole.frames)
    assert found.log_growth.sum() == pytest.approx(whole.log_growth.sum(), rel=0.1)


def test_growth_is_refused_in_clear_words_when_no_pins_are_left_around() -> None:
    images, _ = press()
    tracker = FlowTracker(FlowSettings())
    pins_px = np.array([[140.0, 150], [160, 150], [150, 168], [150, 132], [170, 168], [130, 168], [130, 132]])
    tracker.start(images[0], Region.circle(150, 150, 21), pins_px)
    left = pins_px.copy()
    left[2:] = np.nan
    with pytest.raises(PinsError, match=r"region: expected 3 or more pins in or beside it .* found 2"):
        tracker.step(images[1], left)
    assert tracker.step(images[2], pins_px).log_growth == 0.0, "the bad frame left no trace"


@pytest.mark.parametrize("appearance", ["large", "noisy", "dark"])
def test_large_noisy_and_dark_frames_are_scored_as_the_clean_ones(appearance: str) -> None:
    images, force = press()
    first = int(clean_score().frames[0])
    rows = np.r_[0:4, first : first + 8]
    images, force = images[rows], force[rows]
    clean, settings, scale, within = scored(images, force), SKIN, 1, 0.01
    if appearance == "large":
        scale = 10
        images = np.stack([cv2.resize(image, (3000, 3000), interpolation=cv2.INTER_CUBIC) for image in images])
    elif appearance == "noisy":
        noise = np.random.default_rng(4).normal(0, 15, images.shape)
        images, within = np.clip(images + noise, 0, 255).astype(np.uint8), 0.12
    else:
        images, settings = (
            255 - images,
            ScoreSettings(quantity="skin", flow=FlowSettings(pins=PinSettings(dark_pins=True))),
        )
    found = scored(images, force, settings)
    assert len(found.rest) == 127
    assert found.area[0] / scale**2 == pytest.approx(clean.area[0], rel=within)
    assert found.log_growth.sum() == pytest.approx(clean.log_growth.sum(), rel=within)


@dataclass(frozen=True, kw_only=True)
class SquareSkin(Skin):
    """81 pins on a square grid."""

    rings: int = 4

    @property
    def n_pins(self) -> int:
        return (2 * self.rings + 1) ** 2

    def pins_px(self, centre_px: tuple[float, float]) -> NDArray[np.float64]:
        reach = np.arange(-self.rings, self.rings + 1) * self.pitch_px
        return np.stack(np.meshgrid(reach, reach), axis=-1).reshape(-1, 2) + centre_px


def test_a_square_grid_of_pins_is_scored() -> None:
    made = simulate_press(
        PressSettings(
            stiffness_n_per_mm=SPECIMENS["S5"],
            skin=SquareSkin(pitch_px=23.0),
            world=ContactWorld(),
            timeline=TimelineSettings(loading_s=1.5),
        )
    )
    found = score(made.sequence(), SKIN)
    assert len(found.rest) == 81
    assert not found.notes
    truth = made.truth.area_mm2[found.frames]
    np.testing.assert_allclose(found.area, truth, rtol=0.15)
    assert found.log_growth.sum() == pytest.approx(np.log(truth[-1] / truth[0]), rel=0.02)


def test_pins_of_a_square_grid_count_a_square_each() -> None:
    rest = SquareSkin().pins_px((149.5, 149.5))
    pins = Pins(rest, np.full(81, 64.0))
    contact = rest.copy()
    inner = np.flatnonzero(np.abs(rest - 149.5).max(axis=1) < 21)
    contact[inner] += (0.0, 3.0)
    found = initial_area(pins, contact, rule="hexagon", camera=Camera())
    assert found.selected.tolist() == inner.tolist()
    assert found.area_px2 == pytest.approx(9 * 20.0**2)
    assert Region(found.polygon_px).area_px2 == pytest.approx(60.0**2)
    assert found.area_mm2 == pytest.approx(found.area_px2 * Camera().mm2_per_px2)
    knocked = initial_area(pins, contact + np.array([7.0, 0.0]), rule="hexagon")
    assert knocked.selected.tolist() == inner.tolist()
    assert "common shift of all pins by (7.00, 0.00) px" in " ".join(knocked.notes)


def test_a_sensor_without_pins_is_refused_in_words_that_agree() -> None:
    rng = np.random.default_rng(2)
    places = rng.uniform(20, 280, (12, 2))
    images = np.full((6, 300, 300), 90, np.uint8)
    for k, image in enumerate(images):
        for x, y in places + (40.0 * k if k % 2 else 0.0) * rng.normal(size=(12, 2)):
            cv2.circle(image, (round(x), round(y)), 7, 160, -1)
    with pytest.raises(NoContactError) as refused:
        score(FrameSequence(ArrayFrames(images)))
    assert "only sensors with pins can be scored" in refused.value.do
    assert re.match(r"at most [012] of 1\d; ", refused.value.found)


@pytest.mark.parametrize("dip_n", [0.5, 2.0])
def test_a_press_with_dips_scores_as_without(dip_n: float) -> None:
    press = simulate_press(PressSettings())
    loading = press.truth.force_n[press.truth.loading_frames]
    time = np.linspace(0, 1, loading.size)
    dips = sum(np.exp(-(((time - middle) / 0.04) ** 2)) for middle in (0.4, 0.7))
    rest = np.zeros(4)

    def rate(force_n: np.ndarray) -> float:
        frames = SimulatedFrames(press.scene, np.concatenate([rest, force_n]))
        found = score(FrameSequence(frames, press.settings.camera, frames.force_n)).rate
        return found.value

    assert rate(loading - dip_n * dips) == pytest.approx(rate(loading), rel=0.005)
