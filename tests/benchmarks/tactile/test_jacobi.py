"""The printed iteration of Horn and Schunck."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.tactile.jacobi import cube_derivatives, horn_schunck_jacobi, neighbour_mean, presmoothed

Y, X = np.mgrid[0:24, 0:30].astype(np.float32)


def test_derivatives_of_a_moving_ramp() -> None:
    ix, iy, it = cube_derivatives(2 * X + 3 * Y, 2 * X + 3 * Y - 5)
    inside = np.s_[:-1, :-1]
    assert ix[inside] == pytest.approx(2)
    assert iy[inside] == pytest.approx(3)
    assert it == pytest.approx(-5)


def test_neighbour_mean_keeps_a_constant_and_weighs_as_printed() -> None:
    assert neighbour_mean(np.full((5, 6), 3, np.float32)) == pytest.approx(3)
    one = np.zeros((5, 5), np.float32)
    one[2, 2] = 12
    assert neighbour_mean(one)[1:4, 1:4] == pytest.approx(np.array([[1, 2, 1], [2, 0, 2], [1, 2, 1]]))


def test_no_presmoothing_leaves_the_image() -> None:
    assert np.array_equal(presmoothed(X, 0), X)


def test_finds_a_shift_and_its_sign() -> None:
    def scene(x_px: float, y_px: float) -> np.ndarray:
        return 100 + 50 * np.sin((X - x_px) / 3) + 50 * np.cos((Y - y_px) / 3)

    flow = horn_schunck_jacobi(scene(0, 0), scene(0.4, -0.3), alpha=5, n_iterations=300)
    assert flow[4:-4, 4:-4].mean(axis=(0, 1)) == pytest.approx([0.4, -0.3], rel=0.1)
