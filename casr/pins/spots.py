"""Sub-pixel measurement of spots whose place is roughly known; only the pixels around them are read."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import cast

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.counts import count
from casr.images import Grey

# of the contrast; together the weight of a pixel rises smoothly from zero, which keeps the centroid of a pin from being
# drawn to whole pixels: the pull is 0.2 % of the motion, against 2 % for a plain threshold at 15 %
LEVEL_FRACTION, SOFT_FRACTION = 0.1, 0.2
EVERY, RANK = 4, 2  # background: third darkest of every fourth pixel; a few may be dirt or outside the field of view
SOFT_EDGE_PX = 3.5  # what a disc must hold around a pin's half-brightness edge
SMALLEST_REACH_PX = 2.0
OUT_OF_REACH = np.float32(1e6)  # grey levels no image has
MOST_ROUNDS = 4


@dataclass(frozen=True)
class Spots:
    """Weighted centroid (N, 2) px, area (N,) px, contrast (N,) grey levels; NaN centroid where there is nothing."""

    centroids_px: NDArray[np.float64]
    area_px: NDArray[np.float64]
    contrast: NDArray[np.float64]


def measure_spots(image: Grey, near_px: NDArray[np.float64], reach_px: NDArray[np.float64]) -> Spots:
    """Centroid of the light above the local background within ``reach_px`` of each point.

    The disc moves along until it is centred on what it finds, so a start some pixels off does no harm.
    The weight of a pixel is d^2 / (d + s), where d is its height above background + 10 % of the contrast, and s is
    20 % of the contrast.

    image : (H, W) grey levels, pins bright. near_px : (N, 2) starting points, finite.
    reach_px : (N,) disc radii; at most half way to the next pin.
    """
    widest = max(float(reach_px.max(initial=0.0)), SMALLEST_REACH_PX)
    margin = int(widest)
    padded = cast(Grey, cv2.copyMakeBorder(image, margin, margin, margin, margin, cv2.BORDER_REPLICATE))
    disc = _disc(int(widest**2), padded.shape[1])
    limit = np.array([image.shape[1], image.shape[0]]) - 1.0
    centres = np.clip(np.rint(near_px), 0, limit)
    found = _weigh(padded, centres, reach_px, disc)
    for _ in range(MOST_ROUNDS):
        # a disc off its pin is good enough while the whole pin is still in it
        slack = np.maximum(reach_px - SOFT_EDGE_PX - np.sqrt(found[:, 2] / np.pi), 0.5)
        off = np.flatnonzero(np.abs(found[:, :2] - centres).max(axis=1) > slack)
        if not off.size:
            break
        centres[off] = np.clip(np.rint(found[off, :2]), 0, limit)
        found[off] = _weigh(padded, centres[off], reach_px[off], disc)
    return Spots(found[:, :2], found[:, 2], found[:, 3])


@dataclass(frozen=True)
class _Disc:
    """Offsets x, y (K, 2) and distance (K,) of the pixels of a disc, and their places in a padded image that begins at
    the corner of the first disc."""

    offset: NDArray[np.float64]
    distance: NDArray[np.float32]
    place: NDArray[np.int32]


@lru_cache(maxsize=64)
def _disc(radius_squared: int, width: int) -> _Disc:
    """The disc in a padded image of so many columns."""
    k = math.isqrt(radius_squared)
    y, x = np.mgrid[-k : k + 1, -k : k + 1]
    inside = x * x + y * y <= radius_squared
    offset = np.stack([x, y], axis=-1)[inside].astype(np.float64)
    place = (x + k + (y + k) * width)[inside].astype(np.int32)
    found = _Disc(offset, np.hypot(x, y)[inside].astype(np.float32), place)
    for array in (found.offset, found.distance, found.place):
        array.flags.writeable = False
    return found


def _weigh(
    padded: Grey, centres: NDArray[np.float64], reach_px: NDArray[np.float64], disc: _Disc
) -> NDArray[np.float64]:
    """(N, 4): centroid, area, contrast; the padding of the image is the radius of the disc."""
    start = (centres[:, 0] + centres[:, 1] * padded.shape[1]).astype(np.int32)
    grey = padded.ravel().take(start[:, None] + disc.place).astype(np.float32)
    count("pixels weighed", grey.size)
    beyond = (disc.distance > reach_px[:, None].astype(np.float32)) * OUT_OF_REACH
    background = np.partition(grey[:, ::EVERY] + beyond[:, ::EVERY], RANK, axis=1)[:, RANK]
    grey -= beyond
    top = grey.max(axis=1)
    found = np.empty((len(centres), 4))
    with np.errstate(divide="ignore", invalid="ignore"):  # nothing above the background, or no pixel to tell it from
        contrast = top - background
        weight = np.maximum(grey - (background + np.float32(LEVEL_FRACTION) * contrast)[:, None], 0.0)
        weight *= weight / (weight + np.float32(SOFT_FRACTION) * contrast[:, None])
        exact = weight.astype(np.float64)  # sums in single precision hang on the order that a processor takes
        found[:, :2] = centres + (exact @ disc.offset) / exact.sum(axis=1)[:, None]
        # as bits, eight at a time: a sum of truth values takes several times as long
        bright = np.packbits(grey > (background + 0.5 * contrast)[:, None], axis=1)
        found[:, 2] = np.bitwise_count(bright).sum(axis=1)
    found[:, 3] = contrast
    return found
