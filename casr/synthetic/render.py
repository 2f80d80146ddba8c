"""Pin positions to an image, exact below the pixel: every spot is its profile at its true distance from each pixel."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from casr.synthetic.appearance import SPECKLE_PX, Surface
from casr.synthetic.skin import Skin

EDGE_REACH = 5.5
"A pin is drawn this many edge widths beyond its radius; what is left there is below 0.03 grey levels."
EDGE_SLOPE = math.sqrt(2 / math.pi)
"Makes the steepest point of tanh that of a step blurred by a Gaussian."
SPECKLE_REACH = 3.0
"A speckle is drawn this many standard deviations far."


def render(
    pins_px: NDArray[np.float64],
    surface: Surface,
    skin: Skin,
    *,
    speckle_px: NDArray[np.float64] | None = None,
    noise_grey: float = 0.0,
    rng: np.random.Generator | None = None,
) -> NDArray[np.uint8]:
    """(H, W) uint8 frame.

    Parameters
    ----------
    pins_px : (n_pins, 2) positions; pins move rigidly, their shape stays.
    surface : what does not depend on the positions.
    speckle_px : (S, 2) the texture's positions where the skin has moved; those of ``surface`` by default.
    noise_grey, rng : read noise and where it comes from.
    """
    shape = surface.static_grey.shape
    grey = surface.static_grey + _pins(pins_px, surface.pin_grey, skin, shape)
    if surface.speckle_grey.size:
        grey += _speckles(surface.speckle_px if speckle_px is None else speckle_px, surface.speckle_grey, shape)
    grey *= surface.visible
    if noise_grey > 0 and rng is not None:
        noise = rng.standard_normal(shape, dtype=np.float32)
        noise *= np.float32(noise_grey)
        grey += noise
    np.rint(grey, out=grey)
    return np.clip(grey, 0, 255, out=grey).astype(np.uint8)


def _pins(
    at_px: NDArray[np.float64], brightness: NDArray[np.float32], skin: Skin, shape: tuple[int, ...]
) -> NDArray[np.float32]:
    """Sum of pins: a disc with a soft edge, 1/2 at its radius."""
    pixel, dx, dy, half = _windows(at_px, skin.pin_radius_px + EDGE_REACH * skin.edge_px)
    distance = np.sqrt(dy[:, :, None] ** 2 + dx[:, None, :] ** 2)
    steep = np.float32(EDGE_SLOPE / skin.edge_px)
    grey = np.tanh((np.float32(skin.pin_radius_px) - distance) * steep)
    grey += 1
    grey *= (brightness / 2)[:, None, None]
    return _summed(pixel, grey, half, shape)


def _speckles(
    at_px: NDArray[np.float64], brightness: NDArray[np.float32], shape: tuple[int, ...]
) -> NDArray[np.float32]:
    """Sum of Gaussian speckles."""
    pixel, dx, dy, half = _windows(at_px, SPECKLE_REACH * SPECKLE_PX)
    narrow = np.float32(-0.5 / SPECKLE_PX**2)
    across, down = np.exp(narrow * dx**2), np.exp(narrow * dy**2) * brightness[:, None]
    return _summed(pixel, down[:, :, None] * across[:, None, :], half, shape)


def _windows(
    at_px: NDArray[np.float64], reach_px: float
) -> tuple[NDArray[np.int64], NDArray[np.float32], NDArray[np.float32], int]:
    """Nearest pixel of each spot, its window's offsets along x and y from the spot, and the window's half width."""
    half = math.ceil(reach_px)
    pixel = np.rint(at_px).astype(np.int64)
    steps = np.arange(-half, half + 1)
    offset = ((pixel - at_px)[:, :, None] + steps).astype(np.float32)
    return pixel, offset[:, 0], offset[:, 1], half


def _summed(
    pixel: NDArray[np.int64], grey: NDArray[np.float32], half: int, shape: tuple[int, ...]
) -> NDArray[np.float32]:
    """(H, W) sum of the windows; spots that are not centred in the image are left out."""
    height, width = shape[0] + 2 * half, shape[1] + 2 * half
    inside = ((pixel >= 0) & (pixel < (shape[1], shape[0]))).all(axis=1)
    if not inside.all():
        pixel, grey = pixel[inside], grey[inside]
    steps = np.arange(2 * half + 1)
    corner = pixel[:, 1] * width + pixel[:, 0]
    index = corner[:, None, None] + steps[:, None] * width + steps
    canvas = np.bincount(index.ravel(), weights=grey.ravel(), minlength=height * width).reshape(height, width)
    return canvas[half:-half, half:-half].astype(np.float32)
