"""Pin positions to an image, exact below the pixel: every spot is its profile at its true distance from each pixel."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from emg2vsa.worlds.tactile.appearance import SPECKLE_PX, Surface
from emg2vsa.worlds.tactile.read_noise import read_noise
from emg2vsa.worlds.tactile.skin import Skin

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
    return exposed(drawn(pins_px, surface, skin, speckle_px), noise_grey, rng)


def drawn(
    pins_px: NDArray[np.float64], surface: Surface, skin: Skin, speckle_px: NDArray[np.float64] | None = None
) -> NDArray[np.float32]:
    """(H, W) grey levels before the camera's noise; parameters as those of `render`."""
    grey = surface.static_grey.copy()
    _add_pins(grey, pins_px, surface.pin_grey, skin)
    if surface.speckle_grey.size:
        _add_speckles(grey, surface.speckle_px if speckle_px is None else speckle_px, surface.speckle_grey)
    grey *= surface.visible
    return grey


def exposed(grey: NDArray[np.float32], noise_grey: float, rng: np.random.Generator | None) -> NDArray[np.uint8]:
    """(H, W) uint8 frame of what was `drawn`, which stays as it is."""
    if noise_grey > 0 and rng is not None:
        noise = read_noise(grey.shape, rng)
        noise *= np.float32(noise_grey)
        grey = np.add(grey, noise, out=noise)
        np.rint(grey, out=grey)
    else:
        grey = np.rint(grey)
    return np.clip(grey, 0, 255, out=grey).astype(np.uint8)


def _add_pins(
    image: NDArray[np.float32], at_px: NDArray[np.float64], brightness: NDArray[np.float32], skin: Skin
) -> None:
    """Add each pin: a disc with a soft edge, 1/2 at its radius."""
    corner, dx, dy = _windows(at_px, skin.pin_radius_px + EDGE_REACH * skin.edge_px)
    distance = np.sqrt(dy[:, :, None] ** 2 + dx[:, None, :] ** 2)
    steep = np.float32(EDGE_SLOPE / skin.edge_px)
    spots = np.tanh((np.float32(skin.pin_radius_px) - distance) * steep)
    spots += 1
    spots *= (brightness / 2)[:, None, None]
    _add(image, corner, spots)


def _add_speckles(image: NDArray[np.float32], at_px: NDArray[np.float64], brightness: NDArray[np.float32]) -> None:
    """Add each speckle, a Gaussian."""
    corner, dx, dy = _windows(at_px, SPECKLE_REACH * SPECKLE_PX)
    narrow = np.float32(-0.5 / SPECKLE_PX**2)
    across, down = np.exp(narrow * dx**2), np.exp(narrow * dy**2) * brightness[:, None]
    _add(image, corner, down[:, :, None] * across[:, None, :])


def _windows(
    at_px: NDArray[np.float64], reach_px: float
) -> tuple[NDArray[np.int64], NDArray[np.float32], NDArray[np.float32]]:
    """First pixel of each spot's window, and the distances of its columns and rows from the spot."""
    half = math.ceil(reach_px)
    pixel = np.rint(at_px).astype(np.int64)
    steps = np.arange(-half, half + 1)
    offset = ((pixel - at_px)[:, :, None] + steps).astype(np.float32)
    return pixel - half, offset[:, 0], offset[:, 1]


def _add(image: NDArray[np.float32], corner: NDArray[np.int64], spots: NDArray[np.float32]) -> None:
    """Add the windows to the image, one after the other; what lies outside is dropped."""
    size, (height, width) = spots.shape[1], image.shape
    whole = image.flags.c_contiguous and bool(np.all((corner >= 0) & (corner <= (width - size, height - size))))
    if whole:
        # in the order of the spots too, so that the sums come out the same, at half the cost of a slice for each
        steps = np.arange(size)[:, None] * width + np.arange(size)
        at = (corner[:, 1] * width + corner[:, 0])[:, None, None] + steps
        np.add.at(image.reshape(-1), at.reshape(-1), spots.reshape(-1))
        return
    for (x, y), spot in zip(corner.tolist(), spots, strict=True):
        part = image[max(y, 0) : max(y + size, 0), max(x, 0) : max(x + size, 0)]
        part += spot[max(-y, 0) :, max(-x, 0) :][: part.shape[0], : part.shape[1]]
