"""Images of every type a camera or file gives."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from casr.errors import ImageError
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


@given(st.sampled_from([np.nan, np.inf, -np.inf, 1e300]))
def test_what_is_not_finite_is_counted_and_named(value):
    image = np.zeros((3, 4))
    image[1, 2] = value
    with pytest.raises(ImageError, match=r"press.npy, frame 7.*1 of 12 values NaN or infinite"):
        as_grey(image, where="press.npy, frame 7")


@pytest.mark.parametrize(
    "image",
    [
        np.zeros((0, 5), np.uint8),
        np.zeros(5, np.uint8),
        np.zeros((2, 3, 2), np.uint8),
        np.zeros((1, 2, 3, 3), np.uint8),
        np.float64(3),
        np.zeros((2, 2), np.int32),
        np.zeros((2, 2), complex),
        np.full((2, 2), "a"),
    ],
)
def test_what_is_no_image_is_refused(image):
    with pytest.raises(ImageError, match="expected"):
        as_grey(image)
