"""The affine motion inside a region of a dense flow field."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from casr.flow.divergence import region_mask
from casr.flow.pin_affine import Affine
from casr.flow.region import Region


def fit_field(flow: NDArray[np.float32], region: Region) -> Affine:
    """Least-squares affine motion of the flow over the region; identical frames, so no flow, give exactly 0.

    By Gauss's theorem the trace of the fit is a mean of the divergence over the region with a weight that falls to 0
    towards its border (on a disc of radius R as R^2 - r^2), where dense flow rounds off the kink of a contact and where
    a plain mean would jump as pixels enter.

    Parameters
    ----------
    flow : (H, W, 2) px; only the region's box is read.
    region : in pixels of the flow.

    Raises
    ------
    SettingError : the region lies outside the flow.
    """
    x0, y0, x1, y1 = region.box(flow.shape)
    inside = flow[y0:y1, x0:x1].astype(np.float64)
    left_top = np.array([x0, y0])
    weight = region_mask(region.polygon_px - left_top, inside.shape[:2]).astype(np.float64)
    middle = region.centre_px - left_top
    x, y = np.arange(inside.shape[1]) - middle[0], np.arange(inside.shape[0]) - middle[1]
    # sums of weight times 1, x, y and their products are matrix products over rows and columns
    moments = np.vander(y, 3, increasing=True).T @ weight @ np.vander(x, 3, increasing=True)
    total = moments[0, 0]
    mean = np.array([moments[0, 1], moments[1, 0]]) / total
    spread = np.array([[moments[0, 2], moments[1, 1]], [moments[1, 1], moments[2, 0]]]) / total - np.outer(mean, mean)
    weighted = weight[..., None] * inside
    offset = weighted.sum(axis=(0, 1)) / total
    along = np.stack([x @ weighted.sum(axis=0), y @ weighted.sum(axis=1)], axis=-1).T / total
    matrix = np.linalg.solve(spread, along - np.outer(mean, offset)).T
    energy = float((weighted * inside).sum()) / total
    left = energy - offset @ offset - float(np.sum((matrix @ spread) * matrix))
    rms_px = float(np.sqrt(max(left, 0.0) / 2))
    return Affine(matrix, offset, middle + mean + left_top, rms_px, int(np.count_nonzero(weight)))
