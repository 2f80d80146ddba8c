"""Warping, halving and doubling on fields whose result is known exactly."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from casr.flow.warp import doubled, halved, warp

Y, X = np.mgrid[:24, :30].astype(np.float64)


def _shift(u, v):
    return np.dstack([np.full(X.shape, u), np.full(X.shape, v)])


@settings(max_examples=40, deadline=None)
@given(u=st.floats(-3, 3), v=st.floats(-3, 3))
def test_parabolas_are_reproduced(u, v):
    def surface(x, y):
        return 0.3 * x * x - 0.2 * y * y + 2 * x - y + 5

    got = warp(surface(X, Y), _shift(u, v), 2)
    wanted = surface(X + u, Y + v)
    seen = np.isfinite(got)
    np.testing.assert_allclose(got[seen], wanted[seen], atol=1e-9)
    # lost are the pixels that leave, not more
    inside = (X + u >= 2) & (X + u <= 27) & (Y + v >= 2) & (Y + v <= 21)
    assert (seen == inside).all()


def test_a_ramp_is_read_where_it_lies_in_single_precision():
    got = warp(X.astype(np.float32), _shift(0.25, 0).astype(np.float32), 2)
    assert got.dtype == np.float32
    np.testing.assert_array_equal(got[5, 5:20], X[5, 5:20].astype(np.float32) + np.float32(0.25))


def test_no_motion_returns_the_pixels_themselves():
    image = np.random.default_rng(0).uniform(0, 255, X.shape)
    np.testing.assert_array_equal(warp(image, _shift(0, 0), 2)[2:-2, 2:-2], image[2:-2, 2:-2])


def test_a_missing_pixel_is_missing_in_what_is_read_from_it():
    image = X.copy()
    image[10, 10] = np.nan
    got = warp(image, _shift(0.5, 0.5), 2)
    assert np.isnan(got[8:12, 8:12]).all()
    assert np.isfinite(got[2:8, 2:-3]).all()


@pytest.mark.parametrize("shape", [(24, 30), (23, 29), (1, 1), (2, 5)])
def test_halving_keeps_constants_and_rounds_sizes_up(shape):
    half = halved(np.full(shape, 7.0, np.float32))
    assert half.shape == (-(-shape[0] // 2), -(-shape[1] // 2))
    np.testing.assert_allclose(half, 7, atol=1e-5)


def test_halved_pixels_lie_between_the_pixels_they_cover():
    half = halved(X)
    np.testing.assert_allclose(half[4, 3:-3], 2 * np.arange(3, 12) + 0.5, atol=1e-9)


def test_doubling_is_the_way_back():
    flow = np.dstack([halved(X), halved(Y)]) / 2
    large = doubled(flow, X.shape)
    np.testing.assert_allclose(large[8:-8, 8:-8, 0], X[8:-8, 8:-8], atol=1e-9)
    np.testing.assert_allclose(large[8:-8, 8:-8, 1], Y[8:-8, 8:-8], atol=1e-9)
