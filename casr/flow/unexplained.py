"""What a flow leaves unexplained: the second frame, brought back along it, minus the first."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from casr.flow.compiled import Floats
from casr.flow.warp import warp

BLOCK_PX = 32
ENOUGH_PX = 0.4
ENOUGH_DATA = 0.25  # of the pixels; a flow that carries the others out of the frame explains nothing


@dataclass(frozen=True)
class Unexplained:
    """rms of what is left over the frame's rms gradient, px: how far a motion that explained it would have to reach.

    A flow found right leaves the noise, 0.02 to 0.4 px; a flow found wrong over the whole frame leaves 1 to 3 px.

    Parameters
    ----------
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
    """Of smoothed frames (H, W) and a flow (H, W, 2), px, whose outermost margin px carry no data."""
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
