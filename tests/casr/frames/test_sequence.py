"""A sequence of frames with camera and force."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.tactile.array_frames import ArrayFrames
from casr.camera import Camera
from casr.errors import CameraError, FramesError, ImageError
from casr.frames import FrameSequence

FRAMES = np.arange(4 * 3 * 5, dtype=np.uint8).reshape(4, 3, 5)


def test_frames_by_number_from_either_end_and_in_turn():
    sequence = FrameSequence(ArrayFrames(FRAMES, name="made"))
    assert (sequence.name, len(sequence), sequence.shape) == ("made", 4, (3, 5))
    np.testing.assert_array_equal(sequence[1], FRAMES[1])
    np.testing.assert_array_equal(sequence[-1], FRAMES[3])
    np.testing.assert_array_equal(list(sequence), FRAMES)


@pytest.mark.parametrize("index", [4, -5])
def test_a_frame_that_is_not_there(index):
    with pytest.raises(FramesError, match=f"a frame from 0 to 3, but found frame {index}"):
        FrameSequence(ArrayFrames(FRAMES))[index]


def test_a_bad_frame_is_named_and_the_others_are_read():
    frames = FRAMES.astype(float)
    frames[2, 0, 0] = np.nan
    sequence = FrameSequence(ArrayFrames(frames, name="made"))
    with pytest.raises(ImageError, match="made, frame 2"):
        sequence[2]
    np.testing.assert_array_equal(sequence[3], FRAMES[3])


def test_the_camera_must_have_the_size_of_the_frames():
    FrameSequence(ArrayFrames(FRAMES), Camera(width_px=5, height_px=3))
    with pytest.raises(CameraError, match="3 x 5 px, but found frames of 5 x 3 px"):
        FrameSequence(ArrayFrames(FRAMES), Camera(width_px=3, height_px=5))


def test_one_force_for_each_frame():
    FrameSequence(ArrayFrames(FRAMES), force_n=np.zeros(4))
    with pytest.raises(FramesError, match="one force for each of the 4 frames"):
        FrameSequence(ArrayFrames(FRAMES), force_n=np.zeros(5))


@pytest.mark.parametrize("shape", [(3, 5), (4,), (1, 2, 3, 4, 5)])
def test_arrays_that_are_no_stack_of_frames(shape):
    with pytest.raises(FramesError, match="T, H, W"):
        ArrayFrames(np.zeros(shape, np.uint8))


class Counted(ArrayFrames):
    def __init__(self, frames):
        super().__init__(frames)
        self.asked = []

    def read(self, index):
        self.asked.append(index)
        return super().read(index)


def test_a_frame_that_is_kept_is_decoded_once_and_cannot_be_written_to():
    source = Counted(FRAMES.copy())
    kept = FrameSequence(source).kept()
    for index in (2, 0, 2, -2, 0):
        np.testing.assert_array_equal(kept[index], FRAMES[index])
    assert source.asked == [2, 0]
    with pytest.raises(ValueError, match="read-only"):
        kept[2][0, 0] = 1
    assert source.read(2).flags.writeable


def test_what_is_kept_has_a_limit(monkeypatch):
    monkeypatch.setattr("casr.frames.sequence.MOST_KEPT_BYTES", 2 * FRAMES[0].nbytes)
    source = Counted(FRAMES)
    kept = FrameSequence(source).kept()
    for _ in range(2):
        np.testing.assert_array_equal(list(kept), FRAMES)
    assert source.asked == [0, 1, 2, 3, 2, 3]
