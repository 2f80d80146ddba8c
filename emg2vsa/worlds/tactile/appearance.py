"""What the camera sees: pins on a hexagonal grid inside a round mask, brightness, texture, dirt, glare and read noise.

Of the read noise of each pixel 16 random bits choose one of as many equally likely normal numbers, at a third of what
drawing them costs. Mean and standard deviation are those of a normal distribution, the largest of the numbers is 4.3
standard deviations: of a frame of 90 000 pixels one or two would be beyond. A camera's image is rounded to whole grey
levels, a thousand times coarser than the table.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import cast

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera
from emg2vsa.worlds.tactile.world import check

SPECKLE_PX = 2.2
"Standard deviation of a speckle of the texture, px."
SPECKLE_SPACING_PX = 7.0
"Side of the square each speckle has to itself, px."
DIRT_PX = 2.0
"Correlation length of the dirt on the lens, px."
GLARE_RADIUS_PX = (4.0, 9.0)
"Range of the radius of a reflection, px."
EDGE_REACH = 5.5
"A pin is drawn this many edge widths beyond its radius; what is left there is below 0.03 grey levels."
EDGE_SLOPE = math.sqrt(2 / math.pi)
"Makes the steepest point of tanh that of a step blurred by a Gaussian."
SPECKLE_REACH = 3.0
"A speckle is drawn this many standard deviations far."
_BITS = 16
_REACH, _POINTS = 6.0, 24_001


@dataclass(frozen=True, kw_only=True)
class Skin:
    """Layout of the pins in the image, px.

    Parameters
    ----------
    rings : hexagonal rings around the central pin: 6 give 127 pins, 10 give 331.
    pitch_px : distance of neighbouring pins; 19.84 in frames of a real 127-pin sensor.
    pin_radius_px, edge_px : radius of a pin at half brightness, and the standard deviation of its blurred edge.
    mask_radius_px : beyond it the camera sees black. off_px : of the central pin from the axis of the dome, (x, y).
    """

    rings: int = 6
    pitch_px: float = 20.0
    pin_radius_px: float = 4.5
    edge_px: float = 1.0
    mask_radius_px: float = 140.0
    off_px: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        sizes = (self.pitch_px, self.pin_radius_px, self.edge_px, self.mask_radius_px)
        fits = self.rings >= 1 and all(0 < size < math.inf for size in sizes)
        check(fits, "skin", "sizes above 0, a ring or more", repr(self), "Correct the skin.")
        outermost_px = self.rings * self.pitch_px + math.hypot(*self.off_px)
        check(
            outermost_px + self.pin_radius_px <= self.mask_radius_px, "skin.pitch_px",
            f"{self.rings} rings of pins inside the mask of {self.mask_radius_px:g} px",
            f"an outermost pin at {outermost_px:g} px", "Take a smaller pitch or a larger mask.",
        )  # fmt: skip

    @property
    def n_pins(self) -> int:
        """Number of pins."""
        return 1 + 3 * self.rings * (self.rings + 1)

    def pins_px(self, centre_px: tuple[float, float]) -> NDArray[np.float64]:
        """(n_pins, 2) positions at rest, px, row by row from the top, about the axis of the dome at ``centre_px``."""
        reach = range(-self.rings, self.rings + 1)
        grid = [(column + row / 2, row) for row in reach for column in reach if abs(row + column) <= self.rings]
        middle = np.add(centre_px, self.off_px)
        return np.array(grid) * (self.pitch_px, self.pitch_px * math.sqrt(3) / 2) + middle


TACTIP_127 = Skin()
"The sensor of the paper: 127 pins."


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
        fits = bool(((levels >= 0) & (levels <= 255)).all()) and min(self.n_glare, self.n_missing) >= 0
        wanted = "grey levels from 0 to 255 and numbers of 0 or more"
        check(fits, "appearance", wanted, repr(self), "Correct the appearance.")


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


def drawn(
    pins_px: NDArray[np.float64], surface: Surface, skin: Skin, speckle_px: NDArray[np.float64] | None = None
) -> NDArray[np.float32]:
    """(H, W) grey levels before the camera's noise, exact below the pixel: every spot is its profile at its distance.

    Parameters
    ----------
    pins_px : (n_pins, 2) positions; pins move rigidly, their shape stays.
    surface : what does not depend on the positions.
    speckle_px : (S, 2) the texture's positions where the skin has moved; those of ``surface`` by default.
    """
    grey = surface.static_grey.copy()
    _add_pins(grey, pins_px, surface.pin_grey, skin)
    if surface.speckle_grey.size:
        _add_speckles(grey, surface.speckle_px if speckle_px is None else speckle_px, surface.speckle_grey)
    grey *= surface.visible
    return grey


def exposed(
    grey: NDArray[np.float32], noise_grey: float, rng: np.random.Generator | None,
    room: NDArray[np.float32] | None = None,
) -> NDArray[np.uint8]:  # fmt: skip
    """(H, W) uint8 frame of what was `drawn`, which stays as it is. ``room`` : (H, W) to work in, as new memory takes
    as long as the sums."""
    noise = np.zeros_like(grey) if noise_grey <= 0 or rng is None else read_noise(grey.shape, rng, noise_grey, room)
    # the nearest whole grey level, half way the even one, within 0 and 255
    return cast(NDArray[np.uint8], cv2.add(grey, noise, dtype=cv2.CV_8U))


def _add_pins(
    image: NDArray[np.float32], at_px: NDArray[np.float64], brightness: NDArray[np.float32], skin: Skin
) -> None:
    """Add each pin: a disc with a soft edge, 1/2 at its radius."""
    corner, dx, dy = _windows(at_px, skin.pin_radius_px + EDGE_REACH * skin.edge_px)
    # all in one piece of memory, as new memory takes as long as the sums
    spots = np.add((dy * dy)[:, :, None], (dx * dx)[:, None, :])
    np.subtract(np.float32(skin.pin_radius_px), np.sqrt(spots, out=spots), out=spots)
    spots *= np.float32(EDGE_SLOPE / skin.edge_px)
    np.tanh(spots, out=spots)
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


def read_noise(
    shape: tuple[int, int], rng: np.random.Generator, sd: float = 1.0, out: NDArray[np.float32] | None = None
) -> NDArray[np.float32]:
    """(H, W) independent draws of mean 0 and standard deviation ``sd``, from the bits of ``rng``."""
    size = math.prod(shape)
    words = rng.integers(2**64, size=-(-size * _BITS // 64), dtype=np.uint64).astype("<u8", copy=False)
    out = np.empty(shape, np.float32) if out is None else out
    # every word is a place of the table: a mode other than "raise" writes without another copy, and "wrap" the fastest
    return _table(sd).take(words.view("<u2")[:size].reshape(shape), out=out, mode="wrap")


@lru_cache(maxsize=8)
def _table(sd: float = 1.0) -> NDArray[np.float32]:
    """Quantiles in the middle of equal shares of the normal distribution, scaled to a standard deviation."""
    if sd != 1:
        return _table() * np.float32(sd)
    z = np.linspace(-_REACH, _REACH, _POINTS)
    below = [math.erfc(-each / math.sqrt(2)) / 2 for each in z.tolist()]
    shares = (np.arange(2**_BITS) + 0.5) / 2**_BITS
    quantiles = np.interp(shares, below, z)
    table: NDArray[np.float32] = (quantiles / quantiles.std()).astype(np.float32)
    return table
