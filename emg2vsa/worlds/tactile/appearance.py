"""What the camera sees besides pin positions: brightness, texture, dirt, glare, missing pins, noise."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera
from casr.errors import SettingError
from emg2vsa.worlds.tactile.skin import Skin

SPECKLE_PX = 2.2
"Standard deviation of a speckle of the texture, px."
SPECKLE_SPACING_PX = 7.0
"Side of the square each speckle has to itself, px."
DIRT_PX = 2.0
"Correlation length of the dirt on the lens, px."
GLARE_RADIUS_PX = (4.0, 9.0)
"Range of the radius of a reflection, px."


@dataclass(frozen=True, kw_only=True)
class Appearance:
    """Look of the frames, in grey levels; the defaults are a clean sensor with read noise.

    Parameters
    ----------
    background_grey : of the skin between pins; black beyond the mask.
    pin_grey : least and largest brightness of a pin above the background.
    noise_grey : standard deviation of the read noise, independent in every pixel and frame.
    texture_grey : rms of a texture printed on the skin at first contact; it moves with the skin.
    dirt_grey : rms of dirt and reflections that stay where they are in the image.
    n_glare, glare_grey : number and brightness of round reflections that stay where they are.
    n_missing : pins that are broken off.
    """

    background_grey: float = 20.0
    pin_grey: tuple[float, float] = (119.0, 140.0)
    noise_grey: float = 2.0
    texture_grey: float = 0.0
    dirt_grey: float = 0.0
    n_glare: int = 0
    glare_grey: float = 200.0
    n_missing: int = 0

    def __post_init__(self) -> None:
        levels = np.array([self.background_grey, *self.pin_grey, self.noise_grey, self.texture_grey, self.dirt_grey])
        if not ((levels >= 0) & (levels <= 255)).all() or min(self.n_glare, self.n_missing) < 0:
            raise SettingError(
                "appearance",
                wanted="grey levels from 0 to 255 and numbers of 0 or more",
                found=repr(self),
                do="Correct the appearance.",
            )


@dataclass(frozen=True, eq=False)
class Surface:
    """One sensor's look, drawn once.

    static_grey : (H, W) float32 background, dirt and reflections. visible : (H, W) float32, 0 beyond the mask, else 1.
    pin_grey : (n_pins,) brightness, 0 for a missing pin. speckle_px, speckle_grey : (S, 2), (S,) texture.
    """

    static_grey: NDArray[np.float32]
    visible: NDArray[np.float32]
    pin_grey: NDArray[np.float32]
    speckle_px: NDArray[np.float64]
    speckle_grey: NDArray[np.float32]


def draw_surface(
    appearance: Appearance, skin: Skin, camera: Camera, sensor: np.random.Generator, press: np.random.Generator
) -> Surface:
    """What stays the same through a press: brightness from ``press``; dirt, texture, missing pins from ``sensor``."""
    shape = (camera.height_px, camera.width_px)
    visible = _disc(shape, (camera.cx_px, camera.cy_px), skin.mask_radius_px)
    static = np.full(shape, appearance.background_grey, np.float32)
    if appearance.dirt_grey > 0:
        static += appearance.dirt_grey * _smooth_noise(shape, sensor)
    missing = sensor.permutation(skin.n_pins)[: appearance.n_missing]
    for _ in range(appearance.n_glare):
        angle, share, radius = sensor.uniform(0, 2 * np.pi), np.sqrt(sensor.uniform()), sensor.uniform(*GLARE_RADIUS_PX)
        reach = share * (skin.mask_radius_px - radius)
        centre = (camera.cx_px + reach * np.cos(angle), camera.cy_px + reach * np.sin(angle))
        static += np.float32(appearance.glare_grey) * cv2.GaussianBlur(_disc(shape, centre, radius), (0, 0), 1.0)
    pin_grey = press.uniform(*appearance.pin_grey, skin.n_pins).astype(np.float32)
    pin_grey[missing] = 0.0
    speckle_px, speckle_grey = _texture(appearance.texture_grey, skin, camera, sensor)
    return Surface(static, visible, pin_grey, speckle_px, speckle_grey)


def _disc(shape: tuple[int, int], centre_px: tuple[float, float], radius_px: float) -> NDArray[np.float32]:
    y, x = np.ogrid[: shape[0], : shape[1]]
    return (np.hypot(x - centre_px[0], y - centre_px[1]) <= radius_px).astype(np.float32)


def _smooth_noise(shape: tuple[int, int], rng: np.random.Generator) -> NDArray[np.float32]:
    """(H, W) Gaussian field of mean 0 and standard deviation 1."""
    field = cv2.GaussianBlur(rng.standard_normal(shape, dtype=np.float32), (0, 0), DIRT_PX)
    return np.asarray((field - field.mean()) / field.std(), dtype=np.float32)


def _texture(
    rms_grey: float, skin: Skin, camera: Camera, rng: np.random.Generator
) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
    """Speckles of random sign at random places of the mask; their sum has an rms of ``rms_grey``."""
    if rms_grey == 0:
        return np.empty((0, 2)), np.empty(0, np.float32)
    n_speckles = round(np.pi * skin.mask_radius_px**2 / SPECKLE_SPACING_PX**2)
    distance = skin.mask_radius_px * np.sqrt(rng.uniform(size=n_speckles))
    angle = rng.uniform(0, 2 * np.pi, n_speckles)
    at = np.column_stack([np.cos(angle), np.sin(angle)]) * distance[:, None] + (camera.cx_px, camera.cy_px)
    one_rms = SPECKLE_PX * np.sqrt(np.pi) / SPECKLE_SPACING_PX
    return at, (rng.standard_normal(n_speckles) * rms_grey / one_rms).astype(np.float32)
