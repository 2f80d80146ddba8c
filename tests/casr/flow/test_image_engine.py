"""The mean divergence of the whole image, where the paper's eq. (1) names no region."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from casr.errors import SettingError
from casr.flow.dis import dis_flow
from casr.flow.divergence import divergence
from casr.flow.estimate import FlowSettings, FlowTracker
from casr.flow.region import Region
from casr.frames import FrameSequence, force_per_frame
from casr.scoring import ScoreSettings, score
from emg2vsa.worlds.tactile import PressSettings, TimelineSettings, simulate_press

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


def test_pins_see_no_whole_image() -> None:
    with pytest.raises(SettingError, match="dense engine"):
        FlowTracker(FlowSettings(), whole_image=True)
    for bad in ({"region": "image"}, {"region": "frame", "flow": FlowSettings(engine="dis")}):
        with pytest.raises(SettingError, match="region: expected a region, or 'image' with a dense engine"):
            ScoreSettings(**bad)  # type: ignore[arg-type]


def test_a_press_by_the_whole_image_keeps_its_initial_area() -> None:
    press = simulate_press(PressSettings(timeline=TimelineSettings(loading_s=0.5)))
    log = press.timeline
    force_n = force_per_frame(log.log_force_n, log.log_frame_index, len(press.frames))
    sequence = FrameSequence(press.frames, press.settings.camera, force_n)
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
