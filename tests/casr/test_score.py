"""A press from frames to spread rate, and that nothing is done that was not asked for."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.tactile.press_scores import ArrayFrames
from casr.camera import Camera
from casr.contact_area import initial_area
from casr.counts import counting
from casr.errors import NoContactError, PinsError
from casr.flow.dense_engine import SUPPORT_PX, Dis
from casr.flow.estimate import FlowSettings
from casr.flow.horn_schunck import HornSchunck
from casr.flow.region import Region
from casr.frame_files import open_frames
from casr.frames import FrameSequence
from casr.pins import PinTracker, detect_pins, match_pins
from casr.press_scorer import PressScorer
from casr.scoring import Score, ScoreSettings, score
from casr.specimens import SPECIMENS
from casr.spread import spread_rate
from emg2vsa.worlds.tactile import ContactWorld, PressSettings, SimulatedPress, TabulatedWorld, World, simulate_press

STUCK = ContactWorld()
"The world in which the skin inside the contact grows as the contact does."
ROOT_PITCH_MM = 20 / 6 * 19 / 16
"Of the roots of pins of 3 mm on a sphere of 19 mm, whose tips are 20 px apart at 6 px/mm."


class Counted:
    """Frames that remember which were read."""

    def __init__(self, press: SimulatedPress) -> None:
        self._press, self.name, self.shape = press, press.frames.name, press.frames.shape
        self.read_frames: list[int] = []

    def __len__(self) -> int:
        return len(self._press.frames)

    def read(self, index: int) -> NDArray[np.uint8]:
        self.read_frames.append(index)
        return drawn(self._press, index)


@cache
def drawn(press: SimulatedPress, index: int) -> NDArray[np.uint8]:
    return press.frames.read(index)


@cache
def simulated(specimen: str = "S3", angle_deg: float = 0.0, world: World | None = None) -> SimulatedPress:
    settings = PressSettings(stiffness_n_per_mm=SPECIMENS[specimen], angle_deg=angle_deg)
    return simulate_press(settings if world is None else replace(settings, world=world))


@cache
def scored_by_default(specimen: str, angle_deg: float = 0.0, world: World | None = None) -> Score:
    return score(sequence(simulated(specimen, angle_deg, world)))


def sequence(press: SimulatedPress, camera: Camera | None = None) -> FrameSequence:
    return FrameSequence(Counted(press), camera or press.settings.camera, press.sequence().force_n)


@pytest.mark.parametrize(("specimen", "angle_deg"), [("S1", 0.0), ("S3", 0.0), ("S5", 0.0), ("S3", 30.0), ("S5", 45.0)])
def test_area_and_rate_against_the_truth(specimen: str, angle_deg: float) -> None:
    press = simulated(specimen, angle_deg)
    scored = scored_by_default(specimen, angle_deg)
    true_area = press.truth.area_mm2[scored.frames]
    assert scored.frames[0] in press.truth.loading_frames[0] + np.array([-1, 0, 1])
    assert scored.frames[-1] in press.truth.loading_frames[-1] - np.array([0, 1])
    wide = true_area >= np.pi * (2 * ROOT_PITCH_MM) ** 2
    np.testing.assert_allclose(scored.area[wide], true_area[wide], rtol=0.08)
    true_casr = press.truth.casr_power_mm2_per_n
    assert scored.rate.value == pytest.approx(true_casr, rel=0.06)
    assert scored.interval.low < true_casr < scored.interval.high < 1.25 * scored.rate.value
    assert (scored.area_unit, scored.rate.unit) == ("mm2", "mm2/N")


@pytest.mark.parametrize(("specimen", "angle_deg"), [("S1", 0.0), ("S3", 0.0), ("S5", 0.0), ("S3", 30.0), ("S5", 45.0)])
def test_skin_that_grows_as_the_contact_against_the_truth(specimen: str, angle_deg: float) -> None:
    press = simulated(specimen, angle_deg, STUCK)
    scored = scored_by_default(specimen, angle_deg, STUCK)
    true_area = press.truth.area_mm2[scored.frames]
    # the frame before the true first contact may count as contact: its force is a mean that reaches beyond it
    assert scored.frames[0] in press.truth.loading_frames[0] + np.array([-1, 0, 1])
    assert scored.frames[-1] in press.truth.loading_frames[-1] - np.array([0, 1])
    late = slice(2, None)
    grown = np.log(scored.skin.area[late] / scored.skin.area[2])
    np.testing.assert_allclose(grown, np.log(true_area[late] / true_area[2]), atol=0.006)
    np.testing.assert_allclose(scored.skin.area, true_area, rtol=0.12)
    assert scored.skin.rate.value == pytest.approx(press.truth.casr_slope_mm2_per_n, rel=0.12)


def test_softer_specimens_spread_faster_by_every_rule_of_the_area() -> None:
    hard, soft = (scored_by_default(specimen, 0.0, STUCK) for specimen in ("S1", "S5"))
    for rule in ("hexagon", "edge"):
        first = [initial_area(s.rest, s.contact_px, camera=Camera(), rule=rule).area_mm2 for s in (hard, soft)]
        rates = [
            spread_rate(area / s.skin.area[0] * s.skin.area, s.force_n)
            for area, s in zip(first, (hard, soft), strict=True)
        ]
        assert rates[0].value < rates[1].value


def test_growth_does_not_depend_on_the_rule_of_the_initial_area() -> None:
    press = simulated()
    growths = [
        score(sequence(press), ScoreSettings(area_rule=rule)).log_growth for rule in ("hexagon", "circle", "paper")
    ]
    np.testing.assert_array_equal(growths[0], growths[1])
    np.testing.assert_array_equal(growths[0], growths[2])


def test_skin_that_hardly_moved_refuses_no_press_whose_result_is_the_front() -> None:
    frames, far = sequence(simulated("S5")), ScoreSettings(area_rule="hexagon", threshold_px=20.0)
    found, usual = score(frames, far), score(frames, replace(far, threshold_px=2.0))
    assert found.rate == usual.rate
    assert "skin: no pin moved 20 px at first contact; those that moved 1.4 px count" in " ".join(found.notes)
    assert "no pin moved" not in " ".join(usual.notes)
    with pytest.raises(NoContactError, match="pins that moved more than 20 px"):
        score(frames, replace(far, quantity="skin"))


def test_the_mean_rate_is_over_the_forces_of_the_phase() -> None:
    assert ScoreSettings().window_n == (0.5, 7.0)
    assert ScoreSettings(force_start_n=1.0).window_n == (1.0, 7.0)
    assert ScoreSettings(rate_window_n=(0.5, 3.0), force_stop_n=4.0).window_n == (0.5, 3.0)
    found = score(sequence(simulated()), ScoreSettings(force_start_n=0.8, force_stop_n=4.0))
    assert found.rate is not None
    assert found.rate.window_n == (0.8, 4.0)


def test_only_the_rest_frame_and_the_loading_phase_are_read() -> None:
    press = simulated()
    frames = sequence(press)
    scored = score(frames)
    assert frames.source.read_frames == [scored.rest_frame, *scored.frames]  # type: ignore[attr-defined]
    assert scored.frames[-1] < len(frames) - 1


def test_every_length_fits() -> None:
    scored = scored_by_default("S3")
    n = len(scored.frames)
    assert len(scored.force_n) == len(scored.area) == len(scored.regions) == n
    assert len(scored.divergence) == len(scored.log_growth) == n - 1
    assert scored.contact_px.shape == scored.rest.centroids_px.shape == (127, 2)


def test_without_a_camera_areas_are_in_pixels() -> None:
    press = simulated()
    metric = scored_by_default("S3")
    bare = FrameSequence(Counted(press), None, sequence(press).force_n)
    pixels = score(bare)
    assert pixels.area_unit == "px2"
    np.testing.assert_allclose(pixels.skin.area * press.settings.camera.mm2_per_px2, metric.skin.area)
    assert any("the absolute area depends on what is assumed" in note for note in pixels.notes)


def test_without_force_contact_is_seen_by_the_pins_and_there_is_no_rate() -> None:
    press = simulated()
    scored = score(FrameSequence(Counted(press), press.settings.camera))
    assert scored.rate is None
    assert scored.force_n is None
    assert scored.rest_frame == 0
    assert 0.1 < press.truth.force_n[scored.frames[0]] < 0.7
    assert abs(scored.frames[-1] - press.truth.loading_frames[-1]) <= 1, "unloading is not scored"
    assert any("no force log" in note for note in scored.notes)


def test_a_region_that_is_given_is_the_area_and_is_measured_whole() -> None:
    press = simulated("S5", 0.0, STUCK)
    first = int(press.truth.loading_frames[0])
    a_px = float(press.truth.semi_axes_px[first, 0])
    settings = ScoreSettings(region=Region.circle(*press.truth.centre_px, 0.9 * a_px))
    scored = score(sequence(press), settings)
    assert scored.initial.rule == "given"
    assert scored.skin.area[0] == pytest.approx(np.pi * (0.9 * a_px) ** 2 * press.settings.camera.mm2_per_px2)
    assert scored.log_growth[2:].sum() == pytest.approx(
        np.log(press.truth.area_px2[scored.frames[-1]] / press.truth.area_px2[scored.frames[2]]), rel=0.01
    )


def test_lens_distortion_is_taken_out_of_growth_and_area() -> None:
    press = simulated("S5", 0.0, STUCK)
    straight, settings = press.settings.camera, ScoreSettings(area_rule="edge")
    bent = Camera(distortion=(-0.3, 0.1, 0.0, 0.0))
    points = np.array([[150.0, 150.0], [210.0, 150.0]])
    spread = np.ptp(bent.undistorted_px(points)[:, 0]) / 60
    assert spread > 1.01
    plain, flat = score(sequence(press, straight), settings), score(sequence(press, bent), settings)
    for scored in (plain, flat):
        outlines = [scored.regions[0], scored.regions[-1]]
        camera = straight if scored is plain else bent
        areas = [Region(camera.undistorted_px(outline)).area_px2 for outline in outlines]
        assert scored.log_growth.sum() == pytest.approx(np.log(areas[1] / areas[0]), abs=1e-9)
    assert flat.log_growth.sum() > plain.log_growth.sum() + 0.01


def test_frames_in_no_order_are_reported() -> None:
    press = simulated("S5")
    shift = np.random.default_rng(0).uniform(-16, 16, (12, 2)).round().astype(int)
    image = press.frames.read(20)
    jumping = np.stack([np.roll(image, tuple(by), axis=(0, 1)) for by in shift])
    scored = score(FrameSequence(ArrayFrames(jumping)), ScoreSettings(region=Region.circle(150, 150, 50)))
    assert any("one press, in order?" in note for note in scored.notes)


def test_the_frame_in_which_the_pins_are_lost_is_named() -> None:
    images = np.stack([drawn(simulated("S5"), 20)] * 5)
    images[2:] = 0
    frames = FrameSequence(ArrayFrames(images), None, np.array([0.0, 1.0, 2.0, 3.0, 4.0]))
    with pytest.raises(PinsError, match=r"frame 4.* in 3 frames in a row"):
        score(frames, ScoreSettings(region=Region.circle(150, 150, 50)))


def test_as_json() -> None:
    press = simulated()
    scored = score(sequence(press), ScoreSettings(region=Region.circle(150, 150, 40)))
    told = json.loads(json.dumps(scored.to_dict(), allow_nan=False))
    assert told["frames"] == scored.frames.tolist()
    assert told["settings"]["flow"]["engine"] == "pin-affine"
    assert len(told["settings"]["region"]["polygon_px"]) == 64
    assert told["rate"]["value"] == scored.rate.value  # type: ignore[union-attr]
    assert set(told["provenance"]) == {"casr", "numpy", "opencv", "python"}


@pytest.mark.parametrize(("engine", "tolerance"), [("pin-affine", 0.02), ("horn-schunck", 0.05)])
def test_real_flat_press(shared_data: Callable[[str], Path], engine: str, tolerance: float) -> None:
    """0.290 is ln of the area ratio of the hull of the pins that start within 60 px of the central one."""
    frames = open_frames(shared_data("tactile/tactip127_flat_press_640x480"))
    settings = ScoreSettings(flow=FlowSettings(engine=engine), region=Region.circle(323.6, 240.4, 60))
    scored = score(frames, settings)
    assert scored.log_growth.sum() == pytest.approx(0.290, rel=tolerance)
    assert scored.skin.area[-1] / scored.skin.area[0] == pytest.approx(np.exp(scored.log_growth.sum()))


def test_real_flat_press_touches_when_the_sensor_comes_down(shared_data: Callable[[str], Path]) -> None:
    scored = score(open_frames(shared_data("tactile/tactip127_flat_press_640x480")))
    assert scored.frames[0] == 19, "frames 0 to 18 are at height 0"
    assert 0.05 < scored.log_growth.sum() < 0.3


def test_real_images_in_no_order_give_a_note_or_an_error(shared_data: Callable[[str], Path]) -> None:
    frames = open_frames(shared_data("tactile/tactip127_shapes_300x300") / "cylinderR8")
    try:
        said = " ".join(score(frames, ScoreSettings(region=Region.circle(150, 150, 60))).notes)
    except PinsError as error:
        said = str(error)
    assert "one press, in order?" in said


def test_the_places_of_all_pins_in_every_scored_frame() -> None:
    press = simulated("S5")
    frames = [drawn(press, index) for index in (0, *press.truth.loading_frames[:12].tolist())]
    for engine in ("pin-affine", "dis"):
        scorer = PressScorer(None, ScoreSettings(flow=FlowSettings(engine=engine)))
        scorer.rest(frames[0])
        scorer.touch(frames[1])
        for image in frames[2:]:
            scorer.load(image)
        assert [places.shape for places in scorer.pins_px] == [(127, 2)] * 12
        last_px = detect_pins(frames[-1]).centroids_px
        here, _ = match_pins(scorer.pins_px[-1], last_px, max_distance_px=0.05)
        assert len(here) == 127, "the same row is the same pin, and none is lost"
        moved_px = np.hypot(*np.diff(scorer.pins_px, axis=0).transpose(2, 0, 1))
        assert moved_px.max() < 5, "no pin is taken for the next one"


def test_frames_of_the_unloading_and_of_the_rest_are_not_decoded(monkeypatch: pytest.MonkeyPatch) -> None:
    press = simulated("S5", 0.0, TabulatedWorld())

    def refused(*_: object) -> None:
        raise AssertionError("an engine that nobody asked for")

    monkeypatch.setattr(Dis, "step", refused)
    monkeypatch.setattr(HornSchunck, "step", refused)
    frames = Counted(press)
    with counting() as counts:
        scored = score(FrameSequence(frames, force_n=press.sequence().force_n), ScoreSettings(force_stop_n=3.0))
    asked = {scored.rest_frame, *scored.frames.tolist()}
    assert len(frames) > 2 * len(asked)  # most of the recording is rest and unloading
    assert sorted(frames.read_frames) == sorted(asked)
    assert counts["frames scored"] == len(scored.frames)


def test_dense_flow_weighs_the_box_and_its_support_only() -> None:
    images = np.random.default_rng(1).integers(0, 255, (2, 300, 320)).astype(np.uint8)
    flow = Dis()
    flow.start(images[0])
    with counting() as counts:
        flow.step(images[1], (100, 120, 160, 150))
    assert counts == {"pixels weighed": (60 + 2 * SUPPORT_PX) * (30 + 2 * SUPPORT_PX)}


def test_pins_are_followed_by_the_pixels_around_them() -> None:
    press = simulated("S5")
    tracker, first = PinTracker(), press.frames.read(0)
    with counting() as searched:
        tracker.start(first)
    with counting() as repeated:
        tracker.step(first)
    with counting() as followed:
        tracker.step(press.frames.read(1))
    assert searched["pixels weighed"] >= first.size
    assert repeated == {}  # the same frame moves nothing
    assert 0 < followed["pixels weighed"] < first.size
