"""What counts as a pin, and how frames are looked at for it: large ones reduced, noisy ones smoothed, thresholds to the
pins' size, which follows from their pitch."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.errors import SettingError
from casr.images import Grey, as_grey

FEWEST_PINS = 3


@dataclass(frozen=True, kw_only=True)
class PinSettings:
    """What counts as a pin. What is None follows from the frame: from the pitch of its pins and its noise.

    pitch_px : pin pitch, px; the sizes below, and how far a large frame may be reduced, follow from it.
    block_px : odd side of the square whose mean is the local background; 1.5 pitches.
    contrast : grey levels a pin must stand out from it; 12, more in noise.
    min_area_px : smaller blobs are noise; 2 % of the square of the pitch, 8 for a pitch of 20.
    expect_pins : how many pins the sensor has; another count is said.
    area_ratio : smallest and largest area of one pin over the median pin's.
    max_aspect : largest ratio of the sides of the bounding box.
    min_fill : smallest share of the bounding box that is pin (a disc has 0.79).
    max_brightness_ratio : a blob this many times brighter (above background) than the median pin around it is glare;
        so is a tracked pin that becomes so against the pins around it.
    touching_ratio, most_touching : a blob larger than this many median pins, but not than so many of the largest,
        may be pins that touch; it is cut where it has a waist.
    dark_pins : pins are darker than the skin.
    """

    pitch_px: float | None = None
    block_px: int | None = None
    contrast: float | None = None
    min_area_px: int | None = None
    expect_pins: int | None = None
    area_ratio: tuple[float, float] = (0.3, 2.7)
    max_aspect: float = 2.5
    min_fill: float = 0.45
    max_brightness_ratio: float = 1.35
    touching_ratio: float = 1.6
    most_touching: int = 3
    dark_pins: bool = False

    def __post_init__(self) -> None:
        checks = {
            "pitch_px": (self.pitch_px is None or 3 <= self.pitch_px < math.inf, "a distance from 3 px up"),
            "block_px": (
                self.block_px is None or (self.block_px >= 3 and self.block_px % 2 == 1),
                "an odd number of pixels from 3 up",
            ),
            "contrast": (self.contrast is None or 0 < self.contrast < 255, "grey levels between 0 and 255"),
            "min_area_px": (self.min_area_px is None or self.min_area_px >= 1, "at least one pixel"),
            "expect_pins": (self.expect_pins is None or self.expect_pins >= FEWEST_PINS, f"{FEWEST_PINS} pins or more"),
            "area_ratio": (0 <= self.area_ratio[0] < 1 < self.area_ratio[1], "(below 1, above 1)"),
            "max_aspect": (self.max_aspect >= 1, "1 or more"),
            "min_fill": (0 <= self.min_fill < 1, "a share from 0 to below 1"),
            "touching_ratio": (self.touching_ratio > 1, "above 1"),
            "most_touching": (self.most_touching >= 1, "1 or more; 1 cuts nothing"),
            "max_brightness_ratio": (self.max_brightness_ratio > 1, "above 1"),
        }
        for name, (good, wanted) in checks.items():
            if not good:
                found = repr(getattr(self, name))
                raise SettingError(f"PinSettings.{name}", wanted=wanted, found=found, do="Choose such a value.")


LEAST_SIDE = 32  # px
LARGEST_SIDE = 480  # px; larger frames are reduced for the guess
BROAD_LIGHT = 1 / 7  # of the longer side: light that changes over such lengths is taken off
CLIP_PERCENTILE = 97.0  # lamps and a bright rim count no more than a pin
LEAST_PITCH, LARGEST_SHIFT = 5.0, 1 / 3  # px of the reduced frame; share of its shorter side
LEAST_ALIKE = 0.12  # correlation of the shifted frame; pins of real sensors reach 0.3 and more
NEARLY_BEST = 0.65  # of the best shift: among those the shortest is one pitch, the others are several


def guess_pitch_px(grey: Grey) -> float | None:
    """Pin pitch, px, to about 5 %, by autocorrelation; None where nothing repeats."""
    if min(grey.shape) < LEAST_SIDE:
        return None
    reduction = max(1, -(-max(grey.shape) // LARGEST_SIDE))
    alike = _autocorrelation(reduced(grey, reduction))
    shift = _shortest_good_shift(alike)
    return None if shift is None else reduction * shift


def reduced(grey: Grey, reduction: int) -> Grey:
    """Means of squares of ``reduction`` x ``reduction`` px; rows and columns left over are cut off."""
    if reduction == 1:
        return grey
    height, width = (side // reduction for side in grey.shape)
    whole = grey[: height * reduction, : width * reduction]
    return cast(Grey, cv2.resize(whole, (width, height), interpolation=cv2.INTER_AREA))


def _autocorrelation(grey: Grey) -> NDArray[np.float32]:
    """(rows, columns) correlation of the frame with itself shifted down by the row and right by column - columns//2."""
    height, width = grey.shape
    light = grey.astype(np.float32)
    light -= cv2.GaussianBlur(light, (0, 0), BROAD_LIGHT * max(grey.shape))
    limit = float(np.percentile(np.abs(light[::2, ::2]), CLIP_PERCENTILE))
    light = np.clip(light, -limit, limit)
    light -= light.mean()
    reach = max(2, int(LARGEST_SHIFT * min(grey.shape)))
    size = [cv2.getOptimalDFTSize(side + reach) for side in (height, width)]
    padded = np.zeros(size, np.float32)
    padded[:height, :width] = light
    spectrum = cv2.dft(padded, flags=cv2.DFT_COMPLEX_OUTPUT)
    power = cv2.mulSpectrums(spectrum, spectrum, 0, conjB=True)
    alike = cv2.dft(power, flags=cv2.DFT_INVERSE | cv2.DFT_REAL_OUTPUT | cv2.DFT_SCALE)
    alike = np.roll(alike, reach, axis=1)[: reach + 1, : 2 * reach + 1]
    down, right = np.arange(reach + 1)[:, None], np.abs(np.arange(-reach, reach + 1))
    overlap = (height - down) * (width - right) / (height * width)
    return np.asarray(alike / (overlap * max(float(alike[0, reach]), 1e-6)), np.float32)


def _shortest_good_shift(alike: NDArray[np.float32]) -> float | None:
    reach = len(alike) - 1
    around = cv2.dilate(cv2.GaussianBlur(alike, (0, 0), 1.0), np.ones((5, 5)))
    smooth = cv2.GaussianBlur(alike, (0, 0), 1.0)
    down, right = np.nonzero((smooth >= around) & (smooth > LEAST_ALIKE))
    length = np.hypot(down, right - reach)
    inside = (length >= LEAST_PITCH) & (length < reach - 1)
    if not inside.any():
        return None
    value, length = smooth[down, right][inside], length[inside]
    return float(length[value >= NEARLY_BEST * value.max()].min())


USUAL_PITCH_PX = 20.0  # of a TacTip in frames of 300 to 640 px
SEEN_PITCH_PX = 22.0  # reduced frames keep at least this: more pixels a pin add no accuracy that noise would leave
BLOCK_PITCHES, AREA_PITCHES2 = 1.5, 0.02
USUAL_CONTRAST, NOISES_OF_CONTRAST, MOST_CONTRAST = 12.0, 5.0, 40.0
MEDIAN_OF_NORMAL = 0.6745  # median length of a normal error over its standard deviation
NOISE_LINES = 7  # noise is estimated on every so many lines
QUIET_GREY, LEFT_GREY = 3.0, 1.5  # noise that needs no smoothing; what smoothing aims at
MOST_SMOOTHING = 0.08  # standard deviation over the pitch: pins, 0.45 pitches wide, stay apart


@dataclass(frozen=True)
class PinView:
    """Everything between a frame and the blobs in it.

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
        """The view for pins of this pitch, px, under the noise of this frame (H, W) or (H, W, 3)."""
        reduction = max(1, int(pitch_px / SEEN_PITCH_PX))
        pitch_px /= reduction
        noise = noise_grey(reduced(as_grey(image), reduction))
        smoothing_px = 0.0
        if noise > QUIET_GREY:
            smoothing_px = min(noise / (2 * math.sqrt(math.pi) * LEFT_GREY), MOST_SMOOTHING * pitch_px)
            noise /= max(1.0, 2 * math.sqrt(math.pi) * smoothing_px)
        block, area = settings.block_px, settings.min_area_px
        block_px = BLOCK_PITCHES * pitch_px if block is None else block / reduction
        return cls(
            settings,
            reduction,
            smoothing_px,
            block_px=max(3, 2 * int(block_px / 2) + 1),  # odd
            contrast=settings.contrast or min(max(USUAL_CONTRAST, NOISES_OF_CONTRAST * noise), MOST_CONTRAST),
            min_area_px=AREA_PITCHES2 * pitch_px**2 if area is None else area / reduction**2,
        )

    def grey(self, image: NDArray[Any]) -> Grey:
        """The frame (H, W) or (H, W, 3) as it is looked at: grey levels in which the pins are the bright part. Its
        sides are divided by ``reduction``."""
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
    """``noise_grey`` of each of some lines of a frame (H, W), (lines,) grey levels; black and white pixels included."""
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
