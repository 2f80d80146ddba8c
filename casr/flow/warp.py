"""Second frame brought back along a flow, and images and flows at half and double size.

Cells are squares: pixel i of a halved image covers pixels 2 i and 2 i + 1, its centre lies at 2 i + 0.5.
"""

from __future__ import annotations

import cv2
import numpy as np

from casr.flow.compiled import Floats, kernel


@kernel
def _cubic(p0: float, p1: float, p2: float, p3: float, t: float, half: float) -> float:
    a = p2 - p0
    b = (p0 + p0) - (p1 + p1 + p1 + p1 + p1) + (p2 + p2 + p2 + p2) - p3
    c = (p1 + p1 + p1) - p0 - (p2 + p2 + p2) + p3
    return p1 + half * t * (a + t * (b + t * c))


@kernel
def _warp(second: Floats, flow: Floats, margin: int, out: Floats) -> None:
    height, width = second.shape
    half = second.dtype.type(0.5)
    for y in range(height):
        for x in range(width):
            at_x, at_y = x + flow[y, x, 0], y + flow[y, x, 1]
            if not (margin <= at_x <= width - 1 - margin and margin <= at_y <= height - 1 - margin):
                out[y, x] = np.nan
                continue
            i, j = int(at_x), int(at_y)
            tx, ty = second.dtype.type(at_x - i), second.dtype.type(at_y - j)
            if 1 <= i < width - 2 and 1 <= j < height - 2:
                i0, i1, i2, i3, j0, j1, j2, j3 = i - 1, i, i + 1, i + 2, j - 1, j, j + 1, j + 2
            else:
                i0, i1, i2, i3 = max(i - 1, 0), i, min(i + 1, width - 1), min(i + 2, width - 1)
                j0, j1, j2, j3 = max(j - 1, 0), j, min(j + 1, height - 1), min(j + 2, height - 1)
            a = _cubic(second[j0, i0], second[j0, i1], second[j0, i2], second[j0, i3], tx, half)
            b = _cubic(second[j1, i0], second[j1, i1], second[j1, i2], second[j1, i3], tx, half)
            c = _cubic(second[j2, i0], second[j2, i1], second[j2, i2], second[j2, i3], tx, half)
            d = _cubic(second[j3, i0], second[j3, i1], second[j3, i2], second[j3, i3], tx, half)
            out[y, x] = _cubic(a, b, c, d, ty, half)


def warp(image: Floats, flow: Floats, margin: int) -> Floats:
    """Floats read at every pixel plus its flow; NaN where that lies outside or within margin px of the edge.

    Parameters
    ----------
    image : (H, W) floats.
    flow : (H, W, 2) px, finite.

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
    return cv2.resize(even, (even.shape[1] // 2, even.shape[0] // 2), interpolation=cv2.INTER_AREA)


def doubled(flow: Floats, shape: tuple[int, int]) -> Floats:
    """Flow of a halved image on the image of this shape: bilinear between cell centres, lengths doubled."""
    height, width = shape
    large = cv2.resize(flow, (2 * flow.shape[1], 2 * flow.shape[0]), interpolation=cv2.INTER_LINEAR)
    return np.multiply(large[:height, :width], 2, dtype=flow.dtype)
