"""Flow engines on dense fields: the field around the contact region only, and the affine map that fits its core."""

from __future__ import annotations

from typing import Any, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.errors import SettingError
from casr.flow.pin_affine import Affine
from casr.flow.region import Points, Region
from casr.flow.step import FlowStep
from casr.images import Grey

Array = NDArray[np.float64]
FEWEST_ROWS = 3


SMOOTHING_PX = 1.5
BARE = 0.3  # weight of a pixel without detail over the mean weight: a core that holds two pins has a fit too


def detail_of(image: Grey, region: Region) -> NDArray[np.float32]:
    """Length of the gradient of the smoothed image (H, W), grey levels/px, in the region's box; 0 outside.

    Flow is seen where this is large. Between pins it is filled in, from beyond the edge of the contact too. The square,
    which is the weight of the data in Horn and Schunck's energy, fits a trifle better but trusts reflections more.
    """
    x0, y0, x1, y1 = region.box(image.shape, margin_px=2)
    grey = cv2.GaussianBlur(image[y0:y1, x0:x1].astype(np.float32), (0, 0), SMOOTHING_PX)
    along = [cv2.Sobel(grey, -1, dx, 1 - dx, ksize=1, scale=0.5, borderType=cv2.BORDER_REPLICATE) for dx in (1, 0)]
    detail = np.zeros(image.shape, np.float32)
    detail[y0:y1, x0:x1] = np.hypot(*along)
    return detail


def fit_field(
    flow: NDArray[np.floating[Any]], region: Region, detail: NDArray[np.floating[Any]] | None = None
) -> Affine:
    """Least-squares affine motion of the flow over the region; identical frames, so no flow, give exactly 0.

    By Gauss's theorem the trace of the fit is a mean of the divergence over the region with a weight that falls to 0
    towards its border (on a disc of radius R as R^2 - r^2). There dense flow rounds off the kink of a contact, and
    there pixels enter as the region grows: whole pixels do, where a plain mean needs shares of them.

    Parameters
    ----------
    flow : (H, W, 2) px; only the region's box is read.
    region : in pixels of the flow.
    detail : (H, W) weight of each pixel in the fit, of any unit; None for all alike.

    Raises
    ------
    SettingError : the region lies outside the flow, or holds too few pixels for a fit.
    """
    x0, y0, x1, y1 = region.box(flow.shape)
    left_top = np.array([x0, y0])
    inside = np.zeros((y1 - y0, x1 - x0), np.uint8)
    cv2.fillPoly(inside, [np.rint((region.polygon_px - left_top) * 16).astype(np.int32)], 1, shift=4)
    weight = inside.astype(np.float64)
    n = int(weight.sum())
    if min(np.count_nonzero(weight.any(axis=axis)) for axis in (0, 1)) < FEWEST_ROWS:
        raise SettingError(
            "region",
            wanted=f"{FEWEST_ROWS} or more rows and columns of pixels in its core",
            found=f"{n} pixels around ({region.centre_px[0]:.0f}, {region.centre_px[1]:.0f})",
            do="Give a larger region.",
        )
    if detail is not None and (share := weight * detail[y0:y1, x0:x1]).any():
        weight *= share / share.sum() * n + BARE
    middle = region.centre_px - left_top
    x, y = np.arange(x1 - x0) - middle[0], np.arange(y1 - y0) - middle[1]
    # sums over rows and columns, not matrix products: on this size those would wake the threads of the linear algebra
    along_x, along_y = weight.sum(axis=0), weight.sum(axis=1)
    total = along_x.sum()
    mean = np.array([(along_x * x).sum(), (along_y * y).sum()]) / total
    sum_xy = ((weight * x).sum(axis=1) * y).sum()
    second = np.array([[(along_x * x * x).sum(), sum_xy], [sum_xy, (along_y * y * y).sum()]]) / total
    spread = second - np.outer(mean, mean)
    u, v = (weight * flow[y0:y1, x0:x1, part] for part in (0, 1))
    offset = np.array([u.sum(), v.sum()]) / total
    of_u, of_v = (np.array([(w.sum(axis=0) * x).sum(), (w.sum(axis=1) * y).sum()]) / total for w in (u, v))
    matrix = np.linalg.solve(spread, (np.array([of_u, of_v]) - np.outer(offset, mean)).T).T
    return Affine(matrix, offset, middle + mean + left_top, n)


Box = tuple[int, int, int, int]


class DenseFlow(Protocol):
    """A dense method that keeps the frame before, and says what to know of the flow it gave last."""

    notes: tuple[str, ...]

    def start(self, image: Grey) -> None:
        """Take the first frame."""

    def step(self, image: Grey, roi: Box) -> NDArray[np.floating[Any]]:
        """(H, W, 2) flow from the frame before to this one, px, good in the box (x0, y0, x1, y1)."""


class DenseEngine:
    """Solves the box around the region, fits the core and moves the region along.

    Parameters
    ----------
    method : gives the flow.
    core_fraction : share of the region, about its centroid, that the fit looks at.
    doubt : said of the first step: how wrong its growth may be.
    """

    def __init__(self, method: DenseFlow, core_fraction: float, doubt: str) -> None:
        self._method, self._core_fraction, self._doubt = method, core_fraction, doubt

    def start(self, image: Grey, region: Region, pins_px: Points | None) -> None:
        self._detail = detail_of(image, region)  # a region outside the image is an error of the first frame
        self._method.start(image)
        self._region = region
        self._start_notes: tuple[str, ...] = (self._doubt,)

    def step(self, image: Grey, pins_px: Points | None) -> FlowStep:
        core = self._region.scaled(self._core_fraction)
        fit = fit_field(self._method.step(image, core.box(image.shape)), core, self._detail)
        before, self._region = self._region, self._region.advanced(fit)
        self._detail = detail_of(image, self._region)
        notes, self._start_notes = (*self._start_notes, *self._method.notes), ()
        return FlowStep(*before.growth_to(self._region), self._region, fit.n, notes)
