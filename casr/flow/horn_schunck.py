"""Dense optical flow after Horn & Schunck (Artificial Intelligence 17:185-203, 1981), solved by full multigrid.

Minimised, summed over pixels: (Ix u + Iy v + It)^2 + alpha^2 / 3 |grad (u, v)|^2. With the five-point Laplacian that
is the limit of the paper's iteration (section 12), where alpha^2 weighs a neighbourhood's mean flow minus the flow:
a third of the Laplacian (section 8). Ix and Iy are five-point central differences, the mean of both frames; It is
the second frame minus the first; both frames are smoothed by a Gaussian before. Pixels that the smoothing or a
derivative mixes with what lies beyond the frame carry no data.
"""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.counts import count
from casr.errors import ImageError
from casr.flow.coloured_grid import Floats
from casr.flow.pyramid import Pyramid, longest_px, most_levels
from casr.flow.step import HornSchunckSettings
from casr.flow.warp import rms_gradient
from casr.images import Grey, as_grey

__all__ = ["HornSchunck", "HornSchunckSettings", "horn_schunck"]

Box = tuple[int, int, int, int]
# edges of solved boxes lie on multiples of this, so that work arrays serve again as a region grows
BOX_STEP_PX = 8
# least and largest alpha over the rms gradient of the smoothed frames, grey levels/px: growth within 3 to 5 % on pins
ALPHA_OF_GRADIENT = (0.2, 10.0)


def horn_schunck(
    first: NDArray[Any], second: NDArray[Any], *, settings: HornSchunckSettings | None = None, roi: Box | None = None
) -> Floats:
    """Flow (H, W, 2), px, from first to second (Horn and Schunck 1981); see :meth:`HornSchunck.step`."""
    engine = HornSchunck(settings)
    engine.start(first)
    return engine.step(second, roi)


class HornSchunck:
    """Flow of every frame of a sequence against the one before; each frame is smoothed once.

    notes : what to know of the flow that the last ``step`` gave.
    """

    def __init__(self, settings: HornSchunckSettings | None = None) -> None:
        self.settings = settings or HornSchunckSettings()
        self._dtype = np.dtype(np.float32 if self.settings.single else np.float64)
        self._pyramid = Pyramid(self.settings, self._dtype)
        # two pixels for the derivatives; two standard deviations hold 95 % of the Gaussian
        self._margin = max(2, math.ceil(2 * self.settings.presmoothing_px))
        self._image: Grey | None = None
        self._smooth: tuple[Box, Floats] | None = None
        self._fresh, self._gradient = True, 0.0
        self.notes: tuple[str, ...] = ()

    def start(self, image: NDArray[Any]) -> None:
        """Take the first frame (H, W); it is copied.

        ImageError : not an image.
        """
        self._image, self._smooth = as_grey(image, where="first frame").copy(), None
        self._fresh, self.notes = True, ()

    def step(self, image: NDArray[Any], roi: Box | None = None) -> Floats:
        """Flow from the frame before to this one, which takes its place.

        image : (H, W) frame, of the shape of the one before; copied.
        roi : (x0, y0, x1, y1) px, x1 and y1 excluded: pixels whose flow is wanted. ``support_px`` around them are
            solved too.

        (H, W, 2) flow (u right, v down), px; NaN outside the solved box. float64 for double precision, else float32.
        ImageError : not an image, another shape than the frame before, no frame before, or a region outside.
        """
        second = as_grey(image, where="second frame").copy()
        first = self._before(second)
        box = self._box(second.shape, roi)
        if self._smooth is None or self._smooth[0] != box:
            self._smooth = box, self._smoothed(first, box)
        smooth = self._smoothed(second, box)
        count("pixels weighed", smooth.size)
        if self._fresh:
            self._gradient = rms_gradient(self._smooth[1])
        alpha_notes = self._about_alpha() if self._fresh else ()
        flow = self._pyramid.flow(self._smooth[1], smooth, self._margin, self._gradient)
        if self._wrong and flow.shape[:2] != second.shape:
            flow, box, smooth = self._on_the_whole_frame(first, second, (flow, box, smooth))
        self.notes = (*alpha_notes, *self._about_motion(flow))
        self._fresh, self._image, self._smooth = False, second, (box, smooth)
        return _placed(flow, box, second.shape)

    @property
    def _wrong(self) -> bool:
        return self._pyramid.left is not None and self._pyramid.left.wrong

    def _on_the_whole_frame(
        self, first: Grey, second: Grey, in_box: tuple[Floats, Box, Floats]
    ) -> tuple[Floats, Box, Floats]:
        """A box may be too small for a pyramid deep enough; what it found, if the whole frame is no better."""
        found = self._pyramid.left, self._pyramid.levels
        whole = self._box(second.shape, None)
        smooth = self._smoothed(second, whole)
        flow = self._pyramid.flow(self._smoothed(first, whole), smooth, self._margin, self._gradient)
        if not self._wrong:
            return flow, whole, smooth
        self._pyramid.left, self._pyramid.levels = found
        return in_box

    def _about_alpha(self) -> tuple[str, ...]:
        alpha, gradient = self.settings.alpha, self._gradient
        low, high = (share * gradient for share in ALPHA_OF_GRADIENT)
        if low <= alpha <= high:
            return ()
        what = "small: noise decides the flow" if alpha < low else "large: the flow is smoothed away, growth with it"
        return (
            f"alpha {alpha:g} is too {what}; for the gradient of these frames, {gradient:.2g} grey levels/px, "
            f"give {low:.2g} to {high:.2g}",
        )

    def _about_motion(self, flow: Floats) -> tuple[str, ...]:
        left = self._pyramid.left
        if left is None:  # short and good, or never to be looked at
            return ()
        notes, fixed = [], self.settings.pyramid_levels
        if longest_px(flow) > max(flow.shape[:2]):
            notes.append("the flow is longer than the frame, so it is not to be used: give a larger alpha")
        if left.wrong:
            cause = "are the frames one press, in order, in small steps?"
            if fixed is not None and fixed < most_levels(flow.shape[:2]):
                cause = f"pyramid_levels {fixed} is too few for the motion, leave it at None"
            notes.append(f"the flow does not lead from one frame to the other, so it is not to be used: {cause}")
        return tuple(notes)

    def _before(self, second: Grey) -> Grey:
        if self._image is None or self._image.shape != second.shape:
            found = "no first frame" if self._image is None else f"{self._image.shape} and {second.shape}"
            raise ImageError(
                "second frame", wanted="two frames of one shape", found=found, do="Give frames of one recording."
            )
        return self._image

    def _box(self, shape: tuple[int, ...], roi: Box | None) -> Box:
        height, width = shape
        if roi is None:
            return 0, 0, width, height
        x0, y0, x1, y1 = max(roi[0], 0), max(roi[1], 0), min(roi[2], width), min(roi[3], height)
        if x0 >= x1 or y0 >= y1:
            raise ImageError(
                "region of interest", wanted=f"a box (x0, y0, x1, y1) inside {width} x {height} px", found=str(roi),
                do="Check the region.",
            )  # fmt: skip
        border, step = self.settings.support_px, BOX_STEP_PX
        left, top = (max((n - border) // step * step, 0) for n in (x0, y0))
        right, bottom = (-(-(n + border) // step) * step for n in (x1, y1))
        return left, top, min(right, width), min(bottom, height)

    def _smoothed(self, image: Grey, box: Box) -> Floats:
        """Smoothed pixels of the box; those around it take part."""
        sigma = self.settings.presmoothing_px
        reach = math.ceil(4 * sigma)
        x0, y0, x1, y1 = box
        left, top = min(reach, x0), min(reach, y0)
        part = image[y0 - top : y1 + reach, x0 - left : x1 + reach]
        if sigma == 0:
            return part.astype(self._dtype)
        kernel = cv2.getGaussianKernel(2 * reach + 1, sigma)
        depth = cv2.CV_32F if self._dtype == np.float32 else cv2.CV_64F
        smooth = cv2.sepFilter2D(part, depth, kernel, kernel, borderType=cv2.BORDER_REPLICATE)
        return np.ascontiguousarray(smooth[top : top + y1 - y0, left : left + x1 - x0])


def _placed(flow: Floats, box: Box, shape: tuple[int, ...]) -> Floats:
    if flow.shape[:2] == shape:
        return flow
    out = np.full((*shape, 2), np.nan, flow.dtype)
    out[box[1] : box[3], box[0] : box[2]] = flow
    return out
