"""What counts as a pin."""

from __future__ import annotations

import math
from dataclasses import dataclass

from casr.errors import SettingError

FEWEST_PINS = 3


@dataclass(frozen=True, kw_only=True)
class PinSettings:
    """What counts as a pin. What is None follows from the frame: from the pitch of its pins and its noise.

    Parameters
    ----------
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
