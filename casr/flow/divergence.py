"""How fast a region grows: the divergence of a flow field."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.flow.region import Points, Region

SUBPIXELS = 8


def divergence(flow: NDArray[np.float32]) -> NDArray[np.float32]:
    """(H, W) du/dx + dv/dy of an (H, W, 2) flow, 1/frame; central differences, one-sided at the image border."""
    return np.asarray(np.gradient(flow[..., 0], axis=1) + np.gradient(flow[..., 1], axis=0))


def region_mask(polygon_px: Points, shape: tuple[int, int]) -> NDArray[np.float32]:
    """(H, W) share of each pixel inside the polygon, 0 to 1, so that a mean does not jump as the region grows.

    Parameters
    ----------
    polygon_px : (K, 2) vertices (x, y), px, pixel centres at integers.
    shape : (height, width) of the image.
    """
    fine = np.zeros((shape[0] * SUBPIXELS, shape[1] * SUBPIXELS), dtype=np.uint8)
    corners = (np.asarray(polygon_px) + 0.5) * SUBPIXELS - 0.5
    cv2.fillPoly(fine, [np.rint(corners * 16).astype(np.int32)], 255, shift=4)
    return cv2.resize(fine, shape[::-1], interpolation=cv2.INTER_AREA).astype(np.float32) / np.float32(255)


def mean_divergence(flow: NDArray[np.float32], polygon_px: Points) -> float:
    """Mean divergence of an (H, W, 2) flow over the polygon, 1/frame: D of the paper's eq. (1).

    Raises
    ------
    SettingError : the polygon lies outside the image.
    """
    x0, y0, x1, y1 = Region(polygon_px).box(flow.shape, margin_px=1)
    inside = flow[y0:y1, x0:x1]
    weights = region_mask(polygon_px - (x0, y0), inside.shape[:2])
    return float((weights / weights.sum(dtype=np.float64) * divergence(inside)).sum())
