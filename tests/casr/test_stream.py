"""The same numbers one frame at a time, and the static frame of a long rest."""

from __future__ import annotations

import tracemalloc
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

import casr.stream
from benchmarks.tactile.press_scores import ArrayFrames
from casr.errors import CasrError, FramesError, NoContactError
from casr.flow.estimate import ENGINES, FlowSettings
from casr.frames import FrameSequence, loading_phase
from casr.scoring import Score, ScoreSettings, score
from casr.specimens import SPECIMENS
from casr.stream import RestFrame, StreamScorer, StreamState
from emg2vsa.worlds.tactile import ContactWorld, PressSettings, TabulatedWorld, TimelineSettings, World, simulate_press

Frames = tuple[NDArray[np.uint8], NDArray[np.float64]]
BRISK = TimelineSettings(loading_s=1.5)


@pytest.fixture(scope="module")
def press() -> Frames:
    return pressed(TabulatedWorld())


def pressed(world: World) -> Frames:
    made = simulate_press(PressSettings(stiffness_n_per_mm=SPECIMENS["S3"], world=world, timeline=BRISK))
    return np.stack([made.frames.read(index) for index in range(len(made.frames))]), made.sequence().force_n


def streamed(
    images: NDArray[np.uint8], force_n: NDArray[np.float64], settings: ScoreSettings
) -> tuple[Score, list[StreamState]]:
    stream, buffer, states = StreamScorer(None, settings), np.empty_like(images[0]), []
    for image, force in zip(images, force_n, strict=True):
        buffer[:] = image  # as a camera that writes every frame to the same place
        states.append(stream.push(buffer, float(force)))
    return stream.finish(), states


def assert_same(stream: Score, recording: Score) -> None:
    assert stream.rest_frame == recording.rest_frame
    np.testing.assert_array_equal(stream.frames, recording.frames)
    np.testing.assert_allclose(stream.skin.area, recording.skin.area, rtol=1e-9)
    np.testing.assert_allclose(stream.front.area, recording.front.area, rtol=1e-9)
    np.testing.assert_allclose(stream.divergence, recording.divergence, rtol=0, atol=1e-9)
    np.testing.assert_allclose(stream.contact_px, recording.contact_px)
    assert stream.rate.value == pytest.approx(recording.rate.value, rel=1e-9)
    assert stream.notes == recording.notes


@pytest.mark.parametrize(
    "engine", [pytest.param(name, marks=[pytest.mark.slow] * (name == "horn-schunck")) for name in ENGINES]
)
def test_same_numbers_as_from_a_recording(press: Frames, engine: str) -> None:
    settings = ScoreSettings(flow=FlowSettings(engine=engine))
    assert_same(streamed(*press, settings)[0], score(FrameSequence(ArrayFrames(press[0]), None, press[1]), settings))


@pytest.mark.parametrize("law", ["ode", "paper"])
def test_to_a_force_and_with_either_law(press: Frames, law: str) -> None:
    settings = ScoreSettings(quantity="skin", force_start_n=0.8, force_stop_n=4.0, area_law=law)
    found, states = streamed(*press, settings)
    assert_same(found, score(FrameSequence(ArrayFrames(press[0]), None, press[1]), settings))
    assert states[-1].phase == "done"
    assert states[-1].area == pytest.approx(found.skin.area[-1], rel=1e-12)


def test_a_press_that_turns_back_before_the_force_to_stop_at(press: Frames) -> None:
    images, force = chattering(press)
    settings = ScoreSettings(quantity="skin", force_stop_n=1.1 * float(np.nanmax(force)))
    found, states = streamed(images, force, settings)
    assert_same(found, score(FrameSequence(ArrayFrames(images), None, force), settings))
    assert "done" not in {state.phase for state in states}


def chattering(press: Frames) -> Frames:
    """The touch bounces, the first press is a light one, two frames have no force; then the press."""
    images, force = press
    start = int(np.argmax(force > 0.5))
    bounce = [start - 1, start, start + 1, start - 1, start]
    light = [start - 1, *range(start, start + 12), start - 2]
    order = np.array([*range(start), *bounce, *light, *range(start - 1, len(images))])
    force = force[order].copy()
    force[-30:-28] = np.nan
    return images[order], force


def test_bounces_light_touches_and_frames_without_force(press: Frames) -> None:
    images, force = chattering(press)
    found, states = streamed(images, force, ScoreSettings())
    assert_same(found, score(FrameSequence(ArrayFrames(images), None, force)))
    phases = [state.phase for state in states]
    assert sum(a != b for a, b in pairwise(phases)) >= 6
    assert "done" not in phases


@pytest.mark.parametrize("seed", range(4))
def test_the_same_static_frame_however_the_force_rests(press: Frames, seed: int) -> None:
    images, force = press
    rng = np.random.default_rng(seed)
    start = int(np.argmax(force > 0.5))
    n_rest = int(rng.integers(1, 150))
    resting = rng.normal(0.05, 0.03, n_rest) + np.linspace(0, rng.uniform(0, 0.15), n_rest)
    order = np.array([*rng.integers(0, 4, n_rest), *range(start, start + 4)])
    force = np.concatenate([np.minimum(resting, 0.45), force[start : start + 4]])
    settings = ScoreSettings(quantity="skin")  # in four frames the contact is too small for its front
    found, _ = streamed(images[order], force, settings)
    assert_same(found, score(FrameSequence(ArrayFrames(images[order]), None, force), settings))


def test_state_and_rate_of_the_skin_after_each_frame() -> None:
    images, force = pressed(ContactWorld())  # in which the skin inside the contact grows as the contact does
    stream = StreamScorer(settings=ScoreSettings(quantity="skin"))
    assert stream.spread() is None
    states, spreads = [], []
    for image, f in zip(images[:40], force, strict=False):
        states.append(stream.push(image, float(f)))
        spreads.append(stream.spread())
    loading = [state for state in states if state.phase == "loading"]
    assert [state.frame for state in states] == list(range(40))
    assert all(state.area is None for state in states if state.phase == "rest")
    areas = np.array([state.area for state in loading], dtype=float)
    np.testing.assert_allclose(areas / areas[0], np.exp([state.log_growth or 0.0 for state in loading]), rtol=1e-9)
    assert areas[-1] > 2 * areas[0]
    rates = [spread.rate.value for spread in spreads if spread is not None and spread.rate is not None]
    assert len(rates) >= len(loading) - 2
    assert min(rates) > 0


@pytest.mark.parametrize("settled", [True, False])
def test_front_after_each_frame_is_nearly_that_of_the_finished_press(settled: bool) -> None:
    """Against the score of the whole recording, of a world whose edge is computed by finite elements."""
    made = simulate_press(PressSettings(stiffness_n_per_mm=SPECIMENS["S2"], world=TabulatedWorld()))
    n = int(made.truth.loading_frames[-1]) + 1
    force = made.sequence().force_n[:n]
    images = np.stack([made.frames.read(index) for index in range(n)])
    stream, states = StreamScorer(made.settings.camera), []
    for image, f in zip(images, force, strict=True):
        states.append(stream.push(image, float(f)))
        if settled:
            stream.settle()
    recording = score(FrameSequence(ArrayFrames(images), made.settings.camera, force))
    at_the_time = {state.frame: state.area for state in states if state.area is not None}
    share = np.array([at_the_time[int(k)] / a - 1 for k, a in zip(recording.frames, recording.area, strict=True)
                      if int(k) in at_the_time])  # fmt: skip
    assert share.size >= 0.8 * len(recording.frames)
    assert np.abs(share).max() < 0.03  # as little as the first frames know; areas alone are known to 2.5 %
    assert np.median(np.abs(share)) < 2e-3
    spread = stream.spread()
    assert spread.interval is not None
    assert spread.rate.value == pytest.approx(recording.rate.value, rel=1e-3)
    force_n, area = stream.curve()
    at = np.searchsorted(recording.force_n, force_n)  # of long presses some frames are passed over
    np.testing.assert_allclose(area, recording.area[at], rtol=2e-3)
    assert force_n[-1] == pytest.approx(states[-1].force_n)


def test_lost_pins_do_not_stop_the_rig_but_the_score(press: Frames) -> None:
    images, force = press
    dark = images.copy()
    dark[20:] = 0
    stream = StreamScorer()
    states = [stream.push(image, float(f)) for image, f in zip(dark, force, strict=True)]
    assert states[25].area is None
    assert states[25].notes
    with pytest.raises(CasrError):
        stream.finish()


def test_pins_lost_after_the_peak_do_not_matter(press: Frames) -> None:
    images, force = press
    dark = images.copy()
    dark[int(np.argmax(force)) + 2 :] = 0
    assert_same(streamed(dark, force, ScoreSettings())[0], score(FrameSequence(ArrayFrames(images), None, force)))


def test_no_contact(press: Frames) -> None:
    images, _ = press
    stream = StreamScorer()
    for _ in range(3):
        stream.push(images[0], 0.0)
    with pytest.raises(NoContactError):
        stream.finish()
    with pytest.raises(FramesError, match="static frame"):
        StreamScorer(None, ScoreSettings(tare=False)).push(images[0], 1.0)
    stream = StreamScorer()
    assert stream.push(images[0], 1.0).phase == "rest", "a sensor that was never zeroed may read anything"
    with pytest.raises(FramesError, match="static frame"):
        stream.push(images[0], 2.0)


@pytest.mark.slow
def test_memory_does_not_grow_with_the_sequence(press: Frames) -> None:
    images, force = press
    stream = StreamScorer(settings=ScoreSettings(quantity="skin"))
    tracemalloc.start()
    used = []
    for index in range(2000):
        stream.push(images[index % len(images)], float(force[index % len(images)]))
        if index in (999, 1999):
            used.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    assert used[1] - used[0] < 1_000_000, "1000 frames are 90 MB"


START_N = 0.5


def test_a_long_rest_is_looked_at_ever_more_rarely(monkeypatch: pytest.MonkeyPatch) -> None:
    looks = []

    def counted(force_n, **how):
        looks.append(len(force_n))
        return loading_phase(force_n, **how)

    monkeypatch.setattr(casr.stream, "loading_phase", counted)
    rest, image = RestFrame(START_N), np.zeros((1, 1), np.uint8)
    for _ in range(20_000):
        rest.take(image, 0.0)
    assert len(looks) < 20_000 / 32 / 2
    assert looks[1] - looks[0] == 32


def test_the_frame_is_the_choice_of_all_forces_where_it_is_still_held() -> None:
    rng, rest = np.random.default_rng(1), RestFrame(START_N)
    force_n = 0.01 * rng.standard_normal(9000)
    for k, force in enumerate(force_n.tolist()):
        rest.take(np.array([[k % 256]], np.uint8), force)
    chosen = loading_phase(np.append(force_n, (START_N, 2 * START_N)), start_n=START_N).rest
    assert force_n.size - chosen < 64
    assert rest.image()[0, 0] == chosen % 256
