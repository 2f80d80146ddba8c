"""Forces that are off, of another unit or another time; frames that do not go with them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.tactile.press_scores import ArrayFrames
from casr.errors import AreaError, FramesError, PinsError
from casr.frames import ForceReadings, FrameSequence
from casr.page.wording import camera_lag, force_zero, verdict
from casr.scoring import Score, ScoreSettings, score
from casr.specimens import SPECIMENS
from casr.spread import contact_areas
from casr.stream import StreamScorer
from emg2vsa.worlds.tactile import ContactWorld, PressSettings, SimulatedPress, TimelineSettings, simulate_press

Images = NDArray[np.uint8]
Forces = NDArray[np.float64]
SKIN = ScoreSettings(quantity="skin")


@cache
def press() -> SimulatedPress:
    return simulate_press(PressSettings(stiffness_n_per_mm=SPECIMENS["S3"], world=ContactWorld()))


@cache
def images() -> Images:
    return np.stack([press().frames.read(index) for index in range(len(press().frames))])


def logged() -> Forces:
    force_n = press().sequence().force_n
    assert force_n is not None
    return force_n


def sequence(force_n: Forces | None, frames: Images | None = None, lag_s: float | None = None) -> FrameSequence:
    """With ``lag_s`` the log has times, and the frames are stamped so much too late."""
    found = FrameSequence(ArrayFrames(images() if frames is None else frames), press().settings.camera, force_n)
    return found if lag_s is None else late(found, press(), lag_s)


def late(found: FrameSequence, of: SimulatedPress, lag_s: float) -> FrameSequence:
    line = of.timeline
    readings = ForceReadings(line.log_time_s, line.log_force_n, line.frame_time_s + lag_s)
    return replace(found, force_n=readings.at_frames(), readings=readings)


@cache
def plain() -> Score:
    return scored(sequence(logged()))


def scored(frames: FrameSequence, settings: ScoreSettings | None = None) -> Score:
    return score(frames, settings or SKIN)


@cache
def off_by(offset_n: float) -> Score:
    return scored(sequence(logged() + offset_n))


def casr(found: Score) -> float:
    return found.rate.value


def streamed(force_n: Forces, settings: ScoreSettings | None = None, frames: Images | None = None) -> Score:
    stream = StreamScorer(press().settings.camera, settings or SKIN)
    for image, force in zip(images() if frames is None else frames, force_n, strict=True):
        stream.push(image, float(force))
    return stream.finish()


@pytest.mark.parametrize("offset_n", [0.4, -1.5, 5.0])
def test_an_offset_of_the_force_changes_nothing(offset_n: float) -> None:
    found = off_by(offset_n)
    assert casr(found) == pytest.approx(casr(plain()), rel=1e-9)
    np.testing.assert_allclose(found.force_n, plain().force_n, atol=1e-9)
    zero, before = found.force_zero, plain().force_zero
    assert zero.level_n - before.level_n == pytest.approx(offset_n)
    assert zero.sd_n == pytest.approx(before.sd_n)
    assert abs(before.level_n) < 4 * before.sd_n
    assert any("which is taken off" in note for note in found.notes)
    assert plain().notes == ()


def test_without_tare_an_offset_is_said_and_stays() -> None:
    settings = replace(SKIN, tare=False)
    found = scored(sequence(logged() + 0.4), settings)
    assert found.force_n is not None
    np.testing.assert_allclose(found.force_n, (logged() + 0.4)[found.frames])
    assert not found.force_zero.taken_off
    assert "not taken off" in force_zero(found)
    assert casr(found) < 0.95 * casr(plain())
    assert any("not near zero" in note for note in found.notes)
    stream = streamed(logged() + 0.4, settings)
    assert casr(stream) == pytest.approx(casr(found), rel=1e-9)


def test_too_little_rest_takes_nothing_off() -> None:
    start = 4
    found = scored(sequence(logged()[start:], images()[start:]))
    assert found.force_zero is None
    assert "not determined" in " ".join(found.notes)
    assert force_zero(found).startswith("not determined")
    np.testing.assert_array_equal(found.force_n, logged()[start:][found.frames])


@pytest.mark.parametrize("offset_n", [0.4, -1.5, 5.0])
def test_the_stream_takes_the_same_off(offset_n: float) -> None:
    found, recording = streamed(logged() + offset_n), off_by(offset_n)
    assert found.force_zero == recording.force_zero
    assert found.notes == recording.notes
    np.testing.assert_array_equal(found.frames, recording.frames)
    assert found.rest_frame == recording.rest_frame
    assert casr(found) == pytest.approx(casr(recording), rel=1e-9)


def test_a_spike_in_one_frame_is_no_peak() -> None:
    force_n = logged()
    force_n[30] = 18.0
    found = scored(sequence(force_n))
    assert 30 not in found.frames
    assert found.frames[-1] == plain().frames[-1]
    assert casr(found) == pytest.approx(casr(plain()), rel=0.002)
    assert any("frames have a force that is a spike (up to 18 N)" in note for note in found.notes)
    stream = streamed(force_n)
    assert any("force of frame 30 is a spike" in doubt for doubt in stream.doubts)


def test_millinewtons_are_refused() -> None:
    for scorer in (lambda force_n: scored(sequence(force_n)), streamed):
        with pytest.raises(FramesError, match=r"forces in N, 200 at most, but found 69\d\d.*Which unit"):
            scorer(1000 * logged())


@pytest.mark.parametrize("lag_s", [0.0, 0.1])
def test_the_lag_of_the_camera_is_told_and_corrected(lag_s: float) -> None:
    stamped = sequence(None, lag_s=lag_s)
    found = scored(stamped, replace(SKIN, camera_lag_s=0.0))
    lag = found.camera_lag
    assert abs(lag.lag_s - lag_s) < 2 * lag.sd_s < 0.05
    assert any("the pins begin to move" in note for note in found.notes) == (lag_s > 0)
    unasked = scored(stamped)
    assert unasked.camera_lag.corrected_s == (lag.lag_s if lag_s else 0.0)
    assert any("--camera-lag 0 leaves them" in note for note in unasked.notes) == (lag_s > 0)
    given = scored(stamped, replace(SKIN, camera_lag_s=lag_s))
    right = scored(sequence(None, lag_s=0.0))
    # the zero is that of the frames at rest, and late ones see other readings
    assert np.ptp(given.force_n - right.force_n) < 1e-4
    assert casr(given) == pytest.approx(casr(right), rel=1e-3)
    corrected = scored(stamped, replace(SKIN, correct_lag=True))
    assert corrected.camera_lag.corrected_s == pytest.approx(lag.lag_s, abs=0.005)
    assert not corrected.camera_lag.doubtful
    assert casr(corrected) == pytest.approx(casr(right), rel=0.02)
    assert "taken off" in camera_lag(corrected)


@cache
def fast(kappa: float) -> SimulatedPress:
    """A press of finite elements at 8 N/s and 60 frames/s."""
    camera = replace(PressSettings().camera, frame_rate_hz=60.0)
    timeline = TimelineSettings(loading_s=0.8)
    return simulate_press(PressSettings(stiffness_n_per_mm=kappa, camera=camera, timeline=timeline))


@pytest.mark.parametrize("lag_s", [0.0, 0.02, 0.05, 0.1])
def test_areas_are_right_and_intervals_hold_whatever_the_lag(lag_s: float) -> None:
    """20 ms make the area at 0.5 N 16 % too small here, 100 ms 65 %."""
    for kappa in (SPECIMENS["S3"], SPECIMENS["S5"]):
        of, skin = fast(kappa), fast(kappa).scene.skin
        found = score(late(of.sequence(), of, lag_s))
        assert found.camera_lag.lag_s == pytest.approx(lag_s, abs=0.012)
        assert found.rate.law.area(0.5) == pytest.approx(skin.area_mm2(skin.state(0.5)), rel=0.08)
        assert found.interval.low < of.truth.casr_power_mm2_per_n < found.interval.high


def test_a_lag_needs_times() -> None:
    assert plain().camera_lag is None
    for settings in (replace(SKIN, camera_lag_s=0.05), replace(SKIN, correct_lag=True)):
        with pytest.raises(FramesError, match=r"camera lag: expected .* times"):
            scored(sequence(logged()), settings)


def frozen(at: int, noise_grey: float) -> Images:
    stopped = images().copy()
    stopped[at:] = images()[at]
    noise = np.random.default_rng(0).normal(0, noise_grey, stopped[at:].shape)
    stopped[at:] = np.clip(stopped[at:] + noise, 0, 255).astype(np.uint8)
    return stopped


@pytest.mark.parametrize(
    ("at", "noise_grey"),
    [
        (9, 0.0),
        (40, 2.0),
        *(pytest.param(*row, marks=pytest.mark.slow) for row in ((9, 2.0), (20, 0.0), (20, 2.0), (40, 0.0))),
    ],
)
def test_a_camera_that_stops_is_the_headline(at: int, noise_grey: float) -> None:
    still = frozen(at, noise_grey)
    for found in (scored(sequence(logged(), still)), streamed(logged(), frames=still)):
        assert any("the pins stand still from frame" in doubt for doubt in found.doubts)
        kind, word, seen = verdict(found)
        assert (kind, word) == ("bad", "Check this press:")
        assert "stand still" in seen
        assert any("repeat the one before" in note for note in found.notes) == (noise_grey == 0)


def test_frames_that_go_back_while_the_force_rises() -> None:
    twice = np.concatenate([images()[:40], images()[20 : len(images()) - 20]])
    found = scored(sequence(logged(), twice))
    assert any("the pins go back" in said for said in found.doubts)
    assert verdict(found)[:2] == ("bad", "Check this press:")


def test_frames_backwards_are_refused() -> None:
    with pytest.raises(PinsError, match="are the frames one press, in order"):
        scored(sequence(logged(), images()[::-1]))


def test_a_good_press_has_no_doubts() -> None:
    assert plain().doubts == ()
    assert streamed(logged()).doubts == ()


def test_one_frame_that_repeats_is_a_note() -> None:
    twice = images().copy()
    twice[30] = twice[29]
    found = scored(sequence(logged(), twice))
    assert found.doubts == ()
    assert "frames repeat the one before to the last bit: 30" in " ".join(found.notes)


class Counted(ArrayFrames):
    """Frames that remember which were read."""

    def __init__(self, frames: Images) -> None:
        super().__init__(frames)
        self.read_frames: list[int] = []

    def read(self, index: int) -> Images:
        self.read_frames.append(index)
        return np.asarray(super().read(index))


def test_without_force_each_frame_is_read_once_and_little_of_the_unloading() -> None:
    frames = Counted(images())
    found = score(FrameSequence(frames, press().settings.camera))
    peak = int(press().truth.loading_frames[-1])
    assert frames.read_frames == list(range(len(frames.read_frames)))
    assert abs(int(found.frames[-1]) - peak) <= 1
    assert len(frames.read_frames) - 1 < len(images()) - 2


def test_with_times_each_frame_is_read_once_and_none_of_the_unloading() -> None:
    timed = sequence(None, lag_s=0.0)
    frames = Counted(images())
    found = score(replace(timed, source=frames))
    assert len(set(frames.read_frames)) == len(frames.read_frames)
    assert max(frames.read_frames) == found.frames[-1]


def test_a_bounce_before_the_press_is_not_the_press_without_force() -> None:
    first = int(np.argmax(press().truth.force_n > 0.5))
    order = [*range(first - 5), first + 6, first + 9, first - 5, first - 5, *range(first - 5, len(images()))]
    found = score(FrameSequence(ArrayFrames(images()[order])))
    assert found.frames[0] > first - 1
    peak = int(press().truth.loading_frames[-1])
    assert abs(order[int(found.frames[-1])] - peak) <= 1


def test_equation_1_as_printed_grows_the_skin_beyond_the_array_and_is_refused() -> None:
    known = plain()
    assert known.initial.area_mm2 is not None
    area_mm2 = contact_areas(known.initial.area_mm2, known.divergence, known.force_n, law="paper").max()
    with pytest.raises(
        AreaError, match=r"by equation \(1\) as printed: expected at most the area of the pin"
    ) as refused:
        scored(sequence(logged()), replace(SKIN, area_law="paper"))
    assert f"but found {area_mm2:.5g} mm²" in str(refused.value)
