"""Images of every type a camera or file gives, and a sequence of frames with camera and force."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra import numpy as hnp

from benchmarks.tactile.press_scores import ArrayFrames
from casr.errors import ImageError
from casr.frames import FrameSequence
from casr.images import as_grey

LEVELS = np.arange(256, dtype=np.uint8).reshape(16, 16)


def test_grey_bytes_are_given_back_themselves():
    assert as_grey(LEVELS) is LEVELS


def test_16_bit_levels_span_the_same_range():
    grey = as_grey(LEVELS.astype(np.uint16) * 257)
    assert grey.dtype == np.float32
    np.testing.assert_array_equal(grey, LEVELS)


@pytest.mark.parametrize("kind", [">u2", "<u2", ">f4", "f2", "f8", "u1", "?"])
def test_every_type_ends_as_uint8_or_float32(kind):
    grey = as_grey(np.ones((4, 5), dtype=kind))
    assert grey.dtype in (np.uint8, np.float32)
    assert grey.dtype.isnative
    assert grey.flags.c_contiguous
    assert grey[0, 0] == {">u2": np.float32(1 / 257), "<u2": np.float32(1 / 257), "?": 255}.get(kind, 1)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32, np.float64])
def test_colour_is_weighed_as_opencv_does_and_alpha_is_ignored(dtype):
    colour = np.random.default_rng(1).integers(0, 256, (7, 9, 4)).astype(dtype)
    expected = cv2.cvtColor(colour[..., :3].astype(np.float32), cv2.COLOR_BGR2GRAY) / (257 if dtype == np.uint16 else 1)
    tolerance = 0.51 if dtype == np.uint8 else 1e-4
    np.testing.assert_allclose(as_grey(colour), expected, atol=tolerance)
    np.testing.assert_array_equal(as_grey(colour), as_grey(colour[..., :3]))


def test_one_channel_of_three_dimensions_is_grey():
    np.testing.assert_array_equal(as_grey(LEVELS[..., None]), LEVELS)


@pytest.mark.parametrize("view", [LEVELS[:, ::-1], LEVELS[::2, ::2], LEVELS.T, np.asfortranarray(LEVELS)])
def test_views_become_contiguous_without_changing(view):
    grey = as_grey(view)
    assert grey.flags.c_contiguous
    np.testing.assert_array_equal(grey, view)


@given(hnp.arrays(np.uint8, hnp.array_shapes(min_dims=2, max_dims=2)))
def test_grey_of_grey_changes_nothing(image):
    np.testing.assert_array_equal(as_grey(as_grey(image.astype(np.float64))), image)


FRAMES = np.arange(4 * 3 * 5, dtype=np.uint8).reshape(4, 3, 5)


def test_frames_by_number_from_either_end_and_in_turn():
    sequence = FrameSequence(ArrayFrames(FRAMES, name="made"))
    assert (sequence.name, len(sequence), sequence.shape) == ("made", 4, (3, 5))
    np.testing.assert_array_equal(sequence[1], FRAMES[1])
    np.testing.assert_array_equal(sequence[-1], FRAMES[3])
    np.testing.assert_array_equal(list(sequence), FRAMES)


def test_a_bad_frame_is_named_and_the_others_are_read():
    frames = FRAMES.astype(float)
    frames[2, 0, 0] = np.nan
    sequence = FrameSequence(ArrayFrames(frames, name="made"))
    with pytest.raises(ImageError, match="made, frame 2"):
        sequence[2]
    np.testing.assert_array_equal(sequence[3], FRAMES[3])


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
