"""Second frame brought back along a flow, and images and flows at half and double size.

Cells are squares: pixel i of a halved image covers pixels 2 i and 2 i + 1, its centre lies at 2 i + 0.5.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from casr.flow.compiled import Floats, kernel

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

    Parameters
    ----------
    image : (H, W) floats.
    flow : (H, W, 2) px, finite.
    margin : at least 2.

    Notes
    -----
    Cubic convolution of Keys (IEEE Trans. ASSP 29, 1981) with a = -1/2, which reproduces ramps and parabolas;
    OpenCV's a = -3/4 reads a ramp 0.25 px off as 0.297.
    """
    out = np.empty_like(image)
    _warp(image, flow, margin, out)
    return out


def halved(image: Floats) -> Floats:
    """Half-size image, (ceil H/2, ceil W/2): blurred by sigma 0.8 px against aliasing, then four pixels averaged."""
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
