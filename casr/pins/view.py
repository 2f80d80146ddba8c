"""How the frames of one sensor are looked at: large ones reduced, noisy ones smoothed, thresholds to the pins' size."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.images import Grey, as_grey
from casr.pins.pitch import reduced
from casr.pins.settings import PinSettings

USUAL_PITCH_PX = 20.0  # of a TacTip in frames of 300 to 640 px
SEEN_PITCH_PX = (
    22.0  # reduced frames keep at least this pitch: more pixels a pin add no accuracy that noise would leave
)
BLOCK_PITCHES, AREA_PITCHES2 = 1.5, 0.02
USUAL_CONTRAST, NOISES_OF_CONTRAST, MOST_CONTRAST = 12.0, 5.0, 40.0
MEDIAN_OF_NORMAL = 0.6745  # median length of a normal error over its standard deviation
NOISE_LINES = 7  # noise is estimated on every so many lines
QUIET_GREY, LEFT_GREY = 3.0, 1.5  # noise that needs no smoothing; what smoothing aims at
MOST_SMOOTHING = 0.08  # standard deviation over the pitch: pins, 0.45 pitches wide, stay apart


@dataclass(frozen=True)
class PinView:
    """Everything between a frame and the blobs in it.

    Parameters
    ----------
    settings : what counts as a pin.
    reduction : squares of so many px become one; sizes below are in px of the reduced frame.
    smoothing_px : standard deviation of the Gaussian that noise is smoothed with; 0 for none.
    block_px, contrast, min_area_px : as in ``PinSettings``.
    """

    settings: PinSettings
    reduction: int
    smoothing_px: float
    block_px: int
    contrast: float
    min_area_px: float

    @classmethod
    def of_pitch(cls, image: NDArray[Any], pitch_px: float, settings: PinSettings) -> PinView:
        """The view for pins of this pitch under the noise of this frame."""
        reduction = max(1, int(pitch_px / SEEN_PITCH_PX))
        pitch_px /= reduction
        noise = noise_grey(reduced(as_grey(image), reduction))
        smoothing_px = 0.0
        if noise > QUIET_GREY:
            smoothing_px = min(noise / (2 * math.sqrt(math.pi) * LEFT_GREY), MOST_SMOOTHING * pitch_px)
            noise /= max(1.0, 2 * math.sqrt(math.pi) * smoothing_px)
        block, area = settings.block_px, settings.min_area_px
        return cls(
            settings,
            reduction,
            smoothing_px,
            block_px=_odd(BLOCK_PITCHES * pitch_px if block is None else block / reduction),
            contrast=settings.contrast or min(max(USUAL_CONTRAST, NOISES_OF_CONTRAST * noise), MOST_CONTRAST),
            min_area_px=AREA_PITCHES2 * pitch_px**2 if area is None else area / reduction**2,
        )

    def grey(self, image: NDArray[Any]) -> Grey:
        """The frame as it is looked at: grey levels in which the pins are the bright part."""
        grey = reduced(as_grey(image), self.reduction)
        if self.settings.dark_pins:
            grey = 255 - grey
        if self.smoothing_px:
            grey = cast(Grey, cv2.GaussianBlur(grey, (0, 0), self.smoothing_px))
        return grey

    def in_frame(self, points_px: NDArray[np.float64]) -> NDArray[np.float64]:
        """Places (..., 2) px in the frame of places in the reduced one."""
        return points_px if self.reduction == 1 else points_px * self.reduction + (self.reduction - 1) / 2


def noise_grey(grey: Grey) -> float:
    """Standard deviation of the noise from pixel to pixel, grey levels, beside the edges of pins, black and white."""
    curved, centre = _curved_lines(grey)
    told = curved[(centre > 0) & (centre < 255)]
    return float(np.median(told)) / MEDIAN_OF_NORMAL if told.size else 0.0


def line_noise(grey: Grey) -> NDArray[np.float64]:
    """The same of each of some lines, black and white pixels included."""
    curved, _ = _curved_lines(grey)
    return np.asarray(np.median(curved, axis=1) / MEDIAN_OF_NORMAL, np.float64) if curved.size else np.zeros(1)


def noisy_share(grey: Grey, most: float) -> float:
    """Share of those lines whose noise is above ``most``."""
    curved, _ = _curved_lines(grey)
    if not curved.size:
        return float(most < 0)
    # a line's median is above only where half of it is, which few lines are worth a median to find out
    over = (curved / MEDIAN_OF_NORMAL > np.float64(most)).sum(axis=1)
    noisy = 2 * over > curved.shape[1]
    even = 2 * over == curved.shape[1]
    if even.any():
        noisy[even] = np.median(curved[even], axis=1) / MEDIAN_OF_NORMAL > np.float64(most)
    return float(noisy.mean())


def _curved_lines(grey: Grey) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Second difference along both axes, scaled to the noise of a pixel, and grey level, of pixels on some lines."""
    if min(grey.shape) < 3:
        return np.empty((0, 0), np.float32), np.empty((0, 0), np.float32)
    above, line, below = (grey[row : len(grey) - 2 + row : NOISE_LINES].astype(np.float32) for row in range(3))
    bent = above - 2 * line + below
    return np.abs(bent[:, :-2] - 2 * bent[:, 1:-1] + bent[:, 2:]) / 6, line[:, 1:-1]


def _odd(size_px: float) -> int:
    return max(3, 2 * int(size_px / 2) + 1)
