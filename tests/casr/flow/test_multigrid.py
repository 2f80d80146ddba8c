"""The multigrid solver against a direct solve of the documented equations; warping, halving and doubling."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse
from scipy.sparse.linalg import spsolve

from casr.flow.coloured_grid import flow_of_cells, level, level_table, put_row
from casr.flow.horn_schunck import HornSchunckSettings, horn_schunck
from casr.flow.multigrid import solve
from casr.flow.warp import doubled, halved, warp

LINEAR = HornSchunckSettings(
    presmoothing_px=0, cell_px=1, warp_above_px=np.inf, cycles=60, sweeps=2, precision="double"
)


def _texture(rows, columns, seed, smooth_px=2.0):
    noise = np.random.default_rng(seed).standard_normal((rows + 40, columns + 40))
    image = cv2.GaussianBlur(noise, (0, 0), smooth_px)[20:-20, 20:-20]
    return 120 + 60 * image / image.std()


def _direct(j11, j12, j22, b1, b2, lam):
    """Flow (rows, columns, 2): lam * sum over existing neighbours of (flow_n - flow) = J flow + b."""
    rows, columns = j11.shape

    def path(n):
        return sparse.diags([-np.ones(n - 1), np.r_[1, 2 * np.ones(n - 2), 1], -np.ones(n - 1)], [-1, 0, 1])

    smooth = lam * (sparse.kron(sparse.eye(rows), path(columns)) + sparse.kron(path(rows), sparse.eye(columns)))
    d11, d12, d22 = (sparse.diags(j.ravel()) for j in (j11, j12, j22))
    matrix = sparse.bmat([[smooth + d11, d12], [d12, smooth + d22]], format="csc")
    return spsolve(matrix, -np.r_[b1.ravel(), b2.ravel()]).reshape(2, rows, columns).transpose(1, 2, 0)


def _data(first, second):
    """Products of five-point derivatives, none in the two outermost pixels."""
    stencil = np.array([[1, -8, 0, 8, -1]]) / 12
    mean = (first + second) / 2
    ix, iy, it = cv2.filter2D(mean, -1, stencil), cv2.filter2D(mean, -1, stencil.T), second - first
    inside = np.zeros(first.shape)
    inside[2:-2, 2:-2] = 1
    return [inside * product for product in (ix * ix, ix * iy, iy * iy, ix * it, iy * it)]


@pytest.mark.parametrize("shape", [(24, 32), (27, 40), (61, 22)])
@pytest.mark.parametrize("alpha", [5.0, 30.0, 300.0])
def test_converges_to_the_direct_solution(shape, alpha):
    first = _texture(*shape, 1).astype(np.float32)
    second = (0.9 * first + 0.1 * _texture(*shape, 2)).astype(np.float32)
    wanted = _direct(*_data(first.astype(float), second.astype(float)), alpha**2 / 3)
    flow = horn_schunck(first, second, settings=HornSchunckSettings(**{**vars(LINEAR), "alpha": alpha, "cycles": 200}))
    assert flow.dtype == np.float64
    assert np.abs(flow - wanted).max() < 1e-6 * np.abs(wanted).max()


def test_odd_width_is_solved_with_one_column_without_data():
    first, second = (_texture(20, 31, seed).astype(np.float32) for seed in (3, 4))
    data = [np.pad(product, ((0, 0), (0, 1))) for product in _data(first.astype(float), second.astype(float))]
    wanted = _direct(*data, 300.0)[:, :31]
    assert np.abs(horn_schunck(first, second, settings=LINEAR) - wanted).max() < 1e-6 * np.abs(wanted).max()


def test_single_precision_reaches_its_rounding():
    first, second = (_texture(32, 48, seed).astype(np.float32) for seed in (5, 6))
    wanted = horn_schunck(first, second, settings=LINEAR)
    single = HornSchunckSettings(**{**vars(LINEAR), "precision": "single"})
    assert np.abs(horn_schunck(first, second, settings=single) - wanted).max() < 1e-5 * np.abs(wanted).max()


def _solved(planes, lam, cycles):
    rows, columns = planes[0].shape
    table = level_table(rows, columns)
    work = np.zeros(table[-1, 2])
    finest = level(work, table, 0)
    for plane, values in enumerate(planes, start=2):
        for y in range(rows):
            put_row(finest[plane], y + 1, np.ascontiguousarray(values[y]))
    solve(work, table, np.float64(lam), np.float64(1e-14), 1, cycles)
    flow = np.zeros((rows, columns, 2))
    flow_of_cells(finest, flow)
    return flow


def test_one_full_cycle_is_within_a_few_per_cent():
    planes = _data(_texture(64, 96, 7), _texture(64, 96, 7) + np.linspace(0, 5, 96))
    wanted = _direct(*planes, 300.0)
    assert np.abs(_solved(planes, 300.0, 1) - wanted).max() < 0.05 * np.abs(wanted).max()


@pytest.mark.parametrize("shape", [(4, 256), (256, 4), (6, 130)])
def test_long_strips_converge(shape):
    rng = np.random.default_rng(8)
    ix, iy, it = rng.normal(0, 5, (3, *shape))
    planes = [ix * ix, ix * iy, iy * iy, ix * it, iy * it]
    wanted = _direct(*planes, 300.0)
    assert np.abs(_solved(planes, 300.0, 60) - wanted).max() < 1e-6 * np.abs(wanted).max()


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
