"""Dense flow by OpenCV's DIS (Kroeger et al., ECCV 2016): the reference engine."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.counts import count
from casr.errors import ImageError, SettingError
from casr.images import Grey, as_grey

PRESETS = {
    "ultrafast": cv2.DISOPTICAL_FLOW_PRESET_ULTRAFAST,
    "fast": cv2.DISOPTICAL_FLOW_PRESET_FAST,
    "medium": cv2.DISOPTICAL_FLOW_PRESET_MEDIUM,
}
# below this side OpenCV's pyramid has no level left: an exception, NaN or a crash, depending on the other side
SHORTEST_SIDE_PX = 40
SUPPORT_PX = 24


def dis_flow(first: Grey, second: Grey, *, preset: str = "medium") -> NDArray[np.float32]:
    """Flow from ``first`` to ``second`` by dense inverse search.

    Parameters
    ----------
    first, second : (H, W) images of the same shape, grey levels 0 to 255; crops of a larger image may be given.
    preset : ``"ultrafast"``, ``"fast"`` or ``"medium"``, OpenCV's trade of time against accuracy.

    Returns
    -------
    (H, W, 2) float32, (u right, v down) px.

    Raises
    ------
    ImageError : the shapes differ, or an image is none.
    SettingError : no such preset.
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
        before, after = (_widened(image, missing) for image in (before, after))
    method: Any = cv2.DISOpticalFlow.create(PRESETS[preset])
    return np.ascontiguousarray(method.calc(before, after, None)[:height, :width])


class Dis:
    """DIS from frame to frame.

    Parameters
    ----------
    preset : as for ``dis_flow``.
    """

    notes: tuple[str, ...] = ()

    def __init__(self, preset: str = "medium") -> None:
        self._preset = preset

    def start(self, image: Grey) -> None:
        """Take the first frame."""
        self._before = image.copy()  # a camera may write its next frame into the same memory

    def step(self, image: Grey, roi: tuple[int, int, int, int]) -> NDArray[np.float32]:
        """(H, W, 2) flow from the frame before, px, in the box (x0, y0, x1, y1) and some support; NaN elsewhere."""
        x0, y0 = (max(edge - SUPPORT_PX, 0) for edge in roi[:2])
        x1, y1 = (edge + SUPPORT_PX for edge in roi[2:])
        flow = np.full((*image.shape, 2), np.nan, np.float32)
        flow[y0:y1, x0:x1] = dis_flow(self._before[y0:y1, x0:x1], image[y0:y1, x0:x1], preset=self._preset)
        count("pixels weighed", image[y0:y1, x0:x1].size)
        self._before = image.copy()
        return flow


def _widened(image: NDArray[np.uint8], by: tuple[int, int, int, int]) -> NDArray[np.uint8]:
    return np.asarray(cv2.copyMakeBorder(image, *by, cv2.BORDER_REPLICATE), dtype=np.uint8)


def _bytes(image: Grey) -> NDArray[np.uint8]:
    """DIS takes bytes only; rounding costs at most half a grey level."""
    return np.clip(np.rint(image), 0, 255).astype(np.uint8, copy=False)
