"""Second frame brought back along a flow and what that leaves unexplained; images and flows at half and double size.

Cells are squares: pixel i of a halved image covers pixels 2 i and 2 i + 1, its centre lies at 2 i + 0.5.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from casr.flow.coloured_grid import Floats, kernel

Number = np.floating[Any]
HALF = np.float32(0.5)  # exact, and keeps single precision single


@kernel
def _cubic(p0: Number, p1: Number, p2: Number, p3: Number, t: Number) -> Number:
    a = p2 - p0
    b = (p0 + p0) - (p1 + p1 + p1 + p1 + p1) + (p2 + p2 + p2 + p2) - p3
    c = (p1 + p1 + p1) - p0 - (p2 + p2 + p2) + p3
    twice = t * (a + t * (b + t * c))
    return p1 + twice * HALF


@kernel
def _warp(image: Floats, flow: Floats, margin: int, out: Floats) -> None:
    height, width = image.shape
    number = image.dtype.type
    for y in range(height):
        for x in range(width):
            at_x, at_y = x + flow[y, x, 0], y + flow[y, x, 1]
            if not (margin <= at_x <= width - 1 - margin and margin <= at_y <= height - 1 - margin):
                out[y, x] = np.nan
                continue
            i, j = int(at_x), int(at_y)
            tx, ty = number(at_x - i), number(at_y - j)
            a = _cubic(image[j - 1, i - 1], image[j - 1, i], image[j - 1, i + 1], image[j - 1, i + 2], tx)
            b = _cubic(image[j, i - 1], image[j, i], image[j, i + 1], image[j, i + 2], tx)
            c = _cubic(image[j + 1, i - 1], image[j + 1, i], image[j + 1, i + 1], image[j + 1, i + 2], tx)
            d = _cubic(image[j + 2, i - 1], image[j + 2, i], image[j + 2, i + 1], image[j + 2, i + 2], tx)
            out[y, x] = _cubic(a, b, c, d, ty)


def warp(image: Floats, flow: Floats, margin: int) -> Floats:
    """Image read at every pixel plus its flow; NaN where that lies outside or within margin px of the edge.

    image : (H, W) floats. flow : (H, W, 2) px, finite. margin : at least 2.

    Cubic convolution of Keys (IEEE Trans. ASSP 29, 1981) with a = -1/2, which reproduces ramps and parabolas;
    OpenCV's a = -3/4 reads a ramp 0.25 px off as 0.297.
    """
    out = np.empty_like(image)
    _warp(image, flow, margin, out)
    return out


def halved(image: Floats) -> Floats:
    """Half-size image of one (H, W), (H + 1) // 2 by (W + 1) // 2: blurred by sigma 0.8 px against aliasing, then four
    pixels averaged."""
    height, width = image.shape
    blurred = cv2.GaussianBlur(image, (0, 0), 0.8, borderType=cv2.BORDER_REPLICATE)
    even = cv2.copyMakeBorder(blurred, 0, height % 2, 0, width % 2, cv2.BORDER_REPLICATE)
    half = cv2.resize(even, (even.shape[1] // 2, even.shape[0] // 2), interpolation=cv2.INTER_AREA)
    return np.asarray(half, image.dtype)


def doubled(flow: Floats, shape: tuple[int, ...]) -> Floats:
    """Flow of a halved image on the image of this shape: bilinear between cell centres, lengths doubled."""
    height, width = shape
    large = cv2.resize(flow, (2 * flow.shape[1], 2 * flow.shape[0]), interpolation=cv2.INTER_LINEAR)
    return np.asarray(large[:height, :width] * 2, flow.dtype)


BLOCK_PX = 32
ENOUGH_PX = 0.4
ENOUGH_DATA = 0.25  # of the pixels; a flow that carries the others out of the frame explains nothing


@dataclass(frozen=True)
class Unexplained:
    """rms of what is left over the frame's rms gradient, px: how far a motion that explained it would have to reach.

    A flow found right leaves the noise, 0.02 to 0.4 px; a flow found wrong over the whole frame leaves 1 to 3 px.

    whole_px : over the frame. block_px : over the worst square of 32 px; what is hidden or uncovered leaves 1 to 2 px.
    """

    whole_px: float
    block_px: float

    @property
    def worth_another_level(self) -> bool:
        """Whether a deeper pyramid may explain more."""
        return self.whole_px > ENOUGH_PX or self.block_px > 0.8

    @property
    def wrong(self) -> bool:
        """Whether the flow cannot be believed."""
        return self.whole_px > 0.9

    def clearly_less_than(self, other: Unexplained) -> bool:
        """Less by more than chance: a fifth."""
        return self.whole_px < 0.8 * other.whole_px


def unexplained(first: Floats, second: Floats, flow: Floats, margin: int) -> Unexplained:
    """What a flow leaves over of smoothed frames (H, W) and a flow (H, W, 2), px, whose outermost margin px carry no
    data.
    """
    difference = warp(second, flow, margin) - first
    if min(first.shape) > 2 * margin:
        seen = np.zeros(first.shape, bool)
        seen[margin:-margin, margin:-margin] = True
        seen &= np.isfinite(difference)
    else:
        seen = np.isfinite(difference)
    if not seen.any() or seen.mean() < ENOUGH_DATA:
        return Unexplained(float("inf"), float("inf"))
    squared = np.where(seen, difference, 0).astype(np.float64) ** 2
    gradient = rms_gradient(first)
    if gradient == 0:
        return Unexplained(0.0, 0.0) if not squared.any() else Unexplained(float("inf"), float("inf"))
    block = cv2.blur(squared, (BLOCK_PX, BLOCK_PX), borderType=cv2.BORDER_CONSTANT)
    whole = float(np.sqrt(squared.sum() / seen.sum()))
    return Unexplained(whole / gradient, float(np.sqrt(block.max())) / gradient)


def rms_gradient(image: Floats) -> float:
    """Root mean square length of the gradient of a frame (H, W), grey levels per pixel; 0 for a single pixel."""
    along = [cv2.Sobel(image, -1, dx, 1 - dx, ksize=1, scale=0.5, borderType=cv2.BORDER_REPLICATE) for dx in (1, 0)]
    return float(np.sqrt(sum(np.square(part, dtype=np.float64).mean() for part in along)))
