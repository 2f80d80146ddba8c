"""Horn and Schunck as printed in 1981, in plain NumPy: slow, short, and independent of this package's own solver.

Horn, B. K. P., Schunck, B. G. (1981), Determining optical flow, Artificial Intelligence 17, 185-203.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Field = NDArray[np.float32]


def horn_schunck_jacobi(
    first: NDArray[Any],
    second: NDArray[Any],
    *,
    alpha: float = 15.0,
    n_iterations: int = 100,
    presmoothing_px: float = 1.0,
) -> Field:
    """Flow (H, W, 2) in px from ``first`` to ``second``, both (H, W) in grey levels 0 to 255.

    A hundred iterations are the literature's habit and far from convergence where pins are 10 px apart: the flow has to
    diffuse into the black between them.
    """
    smooth = [presmoothed(image, presmoothing_px) for image in (first, second)]
    return relaxed(*cube_derivatives(*smooth), alpha=alpha, n_iterations=n_iterations)


def presmoothed(image: NDArray[Any], sigma_px: float) -> Field:
    """The image as float32, blurred by a Gaussian; 0 px leaves it as it is."""
    image = image.astype(np.float32)
    return np.asarray(cv2.GaussianBlur(image, (0, 0), sigma_px)) if sigma_px > 0 else image


def cube_derivatives(first: Field, second: Field) -> tuple[Field, Field, Field]:
    """Derivatives by x, y and time, each the mean of four differences in a cube of 2 x 2 x 2 samples (section 7)."""
    low, high = np.pad(first, (0, 1), mode="edge"), np.pad(second, (0, 1), mode="edge")
    both = low + high
    across, down, after = both[:, 1:] - both[:, :-1], both[1:] - both[:-1], high - low
    four = after[:-1, :-1] + after[:-1, 1:] + after[1:, :-1] + after[1:, 1:]
    quarter = np.float32(0.25)
    return quarter * (across[:-1] + across[1:]), quarter * (down[:, :-1] + down[:, 1:]), quarter * four


def relaxed(ix: Field, iy: Field, it: Field, *, alpha: float, n_iterations: int) -> Field:
    """The iteration of section 12 from zero flow; derivatives (H, W) in, flow (H, W, 2) out."""
    u, v = np.zeros_like(ix), np.zeros_like(ix)
    stiffness = np.float32(alpha**2) + ix**2 + iy**2
    for _ in range(n_iterations):
        u_mean, v_mean = neighbour_mean(u), neighbour_mean(v)
        share = (ix * u_mean + iy * v_mean + it) / stiffness
        u, v = u_mean - ix * share, v_mean - iy * share
    return np.stack([u, v], axis=-1)


def neighbour_mean(field: Field) -> Field:
    """Weights 1/6 for the nearest and 1/12 for the diagonal neighbours (section 8); inner means are copied outwards."""
    near = field[:-2, 1:-1] + field[2:, 1:-1] + field[1:-1, :-2] + field[1:-1, 2:]
    diagonal = field[:-2, :-2] + field[:-2, 2:] + field[2:, :-2] + field[2:, 2:]
    return np.pad(near / np.float32(6) + diagonal / np.float32(12), 1, mode="edge")
