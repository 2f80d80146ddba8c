"""Scoring does nothing that was not asked for: frames, engines and pixels are counted."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from casr.counts import counting
from casr.flow.dis import SUPPORT_PX, Dis
from casr.flow.horn_schunck import HornSchunck
from casr.frames import FrameSequence, force_per_frame
from casr.images import Grey
from casr.pins import PinTracker
from casr.scoring import ScoreSettings, score
from casr.specimens import SPECIMENS
from emg2vsa.worlds.tactile import PressSettings, SimulatedPress, TabulatedWorld, simulate_press


class Listed:
    """Frames that keep a list of those that were read."""

    def __init__(self, press: SimulatedPress) -> None:
        self._frames, self.name, self.shape = press.frames, "press", press.frames.shape
        self.read_at: Counter[int] = Counter()

    def __len__(self) -> int:
        return len(self._frames)

    def read(self, index: int) -> Grey:
        self.read_at[index] += 1
        return self._frames.read(index)


@pytest.fixture(scope="module")
def press() -> SimulatedPress:
    return simulate_press(PressSettings(stiffness_n_per_mm=SPECIMENS["S5"], world=TabulatedWorld()))


def test_frames_of_the_unloading_and_of_the_rest_are_not_decoded(
    press: SimulatedPress, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(*_: object) -> None:
        raise AssertionError("an engine that nobody asked for")

    monkeypatch.setattr(Dis, "step", refused)
    monkeypatch.setattr(HornSchunck, "step", refused)
    frames, line = Listed(press), press.timeline
    force_n = force_per_frame(line.log_force_n, line.log_frame_index, len(frames))
    with counting() as counts:
        scored = score(FrameSequence(frames, force_n=force_n), ScoreSettings(force_stop_n=3.0))
    asked = {scored.rest_frame, *scored.frames.tolist()}
    assert len(frames) > 2 * len(asked)  # most of the recording is rest and unloading
    assert frames.read_at == dict.fromkeys(asked, 1)
    assert counts["frames scored"] == len(scored.frames)


def test_dense_flow_weighs_the_box_and_its_support_only() -> None:
    images = np.random.default_rng(1).integers(0, 255, (2, 300, 320)).astype(np.uint8)
    flow = Dis()
    flow.start(images[0])
    with counting() as counts:
        flow.step(images[1], (100, 120, 160, 150))
    assert counts == {"pixels weighed": (60 + 2 * SUPPORT_PX) * (30 + 2 * SUPPORT_PX)}


def test_pins_are_followed_by_the_pixels_around_them(press: SimulatedPress) -> None:
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
