"""Flow engines on dense fields: a field around the contact region and the affine map that fits its core, or the mean
divergence of the whole image; and OpenCV's DIS (Kroeger et al., ECCV 2016), the reference method."""

from __future__ import annotations

from typing import Any, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.counts import count
from casr.errors import ImageError, SettingError
from casr.flow.region import Affine, Points, Region
from casr.flow.step import FlowStep
from casr.images import Grey, as_grey

SUBPIXELS = 8


def divergence(flow: NDArray[np.float32]) -> NDArray[np.float32]:
    """(H, W) du/dx + dv/dy of an (H, W, 2) flow, 1/frame; central differences, one-sided at the image border."""
    return np.asarray(np.gradient(flow[..., 0], axis=1) + np.gradient(flow[..., 1], axis=0))


def region_mask(polygon_px: Points, shape: tuple[int, int]) -> NDArray[np.float32]:
    """(H, W) share of each pixel inside the polygon, 0 to 1, so that a mean does not jump as the region grows.

    polygon_px : (K, 2) vertices (x, y), px, pixel centres at integers. shape : (height, width) of the image.
    """
    fine = np.zeros((shape[0] * SUBPIXELS, shape[1] * SUBPIXELS), dtype=np.uint8)
    corners = (np.asarray(polygon_px) + 0.5) * SUBPIXELS - 0.5
    cv2.fillPoly(fine, [np.rint(corners * 16).astype(np.int32)], 255, shift=4)
    return cv2.resize(fine, shape[::-1], interpolation=cv2.INTER_AREA).astype(np.float32) / np.float32(255)


def mean_divergence(flow: NDArray[np.float32], polygon_px: Points) -> float:
    """Mean divergence of an (H, W, 2) flow over the polygon, 1/frame: D of the paper's eq. (1).

    SettingError : the polygon lies outside the image.
    """
    x0, y0, x1, y1 = Region(polygon_px).box(flow.shape, margin_px=1)
    inside = flow[y0:y1, x0:x1]
    weights = region_mask(polygon_px - (x0, y0), inside.shape[:2])
    return float((weights / weights.sum(dtype=np.float64) * divergence(inside)).sum())


PRESETS = {
    "ultrafast": cv2.DISOPTICAL_FLOW_PRESET_ULTRAFAST,
    "fast": cv2.DISOPTICAL_FLOW_PRESET_FAST,
    "medium": cv2.DISOPTICAL_FLOW_PRESET_MEDIUM,
}
# below this side OpenCV's pyramid has no level left: an exception, NaN or a crash, depending on the other side
SHORTEST_SIDE_PX = 40
SUPPORT_PX = 24


def dis_flow(first: Grey, second: Grey, *, preset: str = "medium") -> NDArray[np.float32]:
    """Flow from ``first`` to ``second`` by dense inverse search (Kroeger et al. 2016).

    first, second : (H, W) images of the same shape, grey levels 0 to 255; crops of a larger image may be given.
    preset : ``"ultrafast"``, ``"fast"`` or ``"medium"``, OpenCV's trade of time against accuracy.
    Returns (H, W, 2) float32, (u right, v down) px.
    ImageError : the shapes differ, or an image is none. SettingError : no such preset.
    """
    if preset not in PRESETS:
        raise SettingError(
            "dis_preset", wanted=f"one of {', '.join(PRESETS)}", found=repr(preset), do="Choose one of these presets."
        )
    before, after = _bytes(as_grey(first, where="first image")), _bytes(as_grey(second, where="second image"))
    if before.shape != after.shape:
        raise ImageError(
            "image pair", wanted="two images of one shape", found=f"{before.shape} and {after.shape}", do="Crop them."
        )
    height, width = before.shape
    missing = (0, max(0, SHORTEST_SIDE_PX - height), 0, max(0, SHORTEST_SIDE_PX - width))
    if any(missing):
        before, after = (
            cv2.copyMakeBorder(image, *missing, cv2.BORDER_REPLICATE).astype(np.uint8) for image in (before, after)
        )
    method: Any = cv2.DISOpticalFlow.create(PRESETS[preset])
    return np.ascontiguousarray(method.calc(before, after, None)[:height, :width])


class Dis:
    """DIS from frame to frame.

    preset : as for ``dis_flow``.
    """

    notes: tuple[str, ...] = ()

    def __init__(self, preset: str = "medium") -> None:
        self._preset = preset

    def start(self, image: Grey) -> None:
        """Take the first frame."""
        self._before = image.copy()  # a camera may write its next frame into the same memory

    def step(self, image: Grey, roi: tuple[int, int, int, int]) -> NDArray[np.float32]:
        """(H, W, 2) flow from the frame before (Kroeger et al. 2016), px, in the box (x0, y0, x1, y1) and some support;
        NaN elsewhere."""
        x0, y0 = (max(edge - SUPPORT_PX, 0) for edge in roi[:2])
        x1, y1 = (edge + SUPPORT_PX for edge in roi[2:])
        flow = np.full((*image.shape, 2), np.nan, np.float32)
        flow[y0:y1, x0:x1] = dis_flow(self._before[y0:y1, x0:x1], image[y0:y1, x0:x1], preset=self._preset)
        count("pixels weighed", image[y0:y1, x0:x1].size)
        self._before = image.copy()
        return flow


def _bytes(image: Grey) -> NDArray[np.uint8]:
    """DIS takes bytes only; rounding costs at most half a grey level."""
    return np.clip(np.rint(image), 0, 255).astype(np.uint8, copy=False)


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

    flow : (H, W, 2) px; only the region's box is read. region : in pixels of the flow.
    detail : (H, W) weight of each pixel in the fit, of any unit; None for all alike.
    SettingError : the region lies outside the flow, or holds too few pixels for a fit.
    Why an affine fit: decision 10.
    """
    x0, y0, x1, y1 = region.box(flow.shape)
    left_top = np.array([x0, y0])
    inside = np.zeros((y1 - y0, x1 - x0), np.uint8)
    cv2.fillPoly(inside, [np.rint((region.polygon_px - left_top) * 16).astype(np.int32)], 1, shift=4)
    weight = inside.astype(np.float64)
    n = int(weight.sum())
    if min(np.count_nonzero(weight.any(axis=axis)) for axis in (0, 1)) < FEWEST_ROWS:
        raise SettingError(
            "region", wanted=f"{FEWEST_ROWS} or more rows and columns of pixels in its core",
            found=f"{n} pixels around ({region.centre_px[0]:.0f}, {region.centre_px[1]:.0f})",
            do="Give a larger region.",
        )  # fmt: skip
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

    method : gives the flow. core_fraction : share of the region, about its centroid, that the fit looks at.
    doubt : said of the first step: how wrong its growth may be.
    """

    def __init__(self, method: DenseFlow, core_fraction: float, doubt: str) -> None:
        self._method, self._core_fraction, self.start_notes = method, core_fraction, (doubt,)

    def start(self, image: Grey, region: Region, pins_px: Points | None) -> None:
        """Take the first frame. SettingError : the region lies outside the image. ``pins_px`` (N, 2) px has no part in
        it."""
        self._detail = detail_of(image, region)  # a region outside the image is an error of the first frame
        self._method.start(image)
        self._region = region

    def step(self, image: Grey, pins_px: Points | None) -> FlowStep:
        """Growth of the region from the frame before to this one; the region goes on as the map of its core says.

        ``pins_px`` (N, 2) px has no part in it.
        """
        core = self._region.scaled(self._core_fraction)
        fit = fit_field(self._method.step(image, core.box(image.shape)), core, self._detail)
        before, self._region = self._region, self._region.advanced(fit)
        self._detail = detail_of(image, self._region)
        return FlowStep(*before.growth_to(self._region), self._region, fit.n, self._method.notes)


DOUBT = (
    "growth is the mean divergence of the whole image: what lies outside the contact counts as much as the contact, so "
    "that it depends on how the frames are cropped"
)


class ImageEngine:
    """Solves all of the image and takes the mean; the contact region stays where it is, for pictures only."""

    def __init__(self, method: DenseFlow) -> None:
        self._method, self.start_notes = method, (DOUBT,)

    def start(self, image: Grey, region: Region, pins_px: Points | None) -> None:
        """Take the first frame. ``pins_px`` (N, 2) px has no part in it."""
        self._method.start(image)
        self._region = region

    def step(self, image: Grey, pins_px: Points | None) -> FlowStep:
        """Mean divergence of the whole image from the frame before to this one. ``pins_px`` (N, 2) px has no part in
        it."""
        height, width = image.shape
        flow = self._method.step(image, (0, 0, width, height))
        mean = float(divergence(flow.astype("float32", copy=False)).mean())
        return FlowStep(mean, mean, self._region, height * width, self._method.notes)
