"""Find the pins of one frame (Algorithm 1, step 1 and 2: shape mask, colour mask, centroids), to sub-pixel accuracy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from casr.errors import PinsError, SettingError
from casr.images import Grey, as_grey
from casr.pins.blobs import Blobs, above_surroundings, find_blobs, halves
from casr.pins.lattice import nearest_pins
from casr.pins.spots import measure_spots

MOST_BLOBS = 3000


@dataclass(frozen=True, kw_only=True)
class PinSettings:
    """What counts as a pin. The defaults suit pins of 5 to 20 px diameter, 9 px and more apart.

    Parameters
    ----------
    block_px : odd side of the square whose mean is the local background; about 1.5 pitches.
    contrast : grey levels a pin must stand out from it; 6 times the camera's noise.
    min_area_px : smaller blobs are noise.
    area_ratio : smallest and largest area of one pin over the median pin's.
    max_aspect : largest ratio of the sides of the bounding box.
    min_fill : smallest share of the bounding box that is pin (a disc has 0.79).
    max_brightness_ratio : a blob this many times brighter (above background) than the median pin around it is glare.
    split_touching : cut blobs that are several pins into those pins.
    dark_pins : pins are darker than the skin.
    integer_centroids : cut centroids to whole pixels as the paper's Algorithm 1 does (0.7 px rms; for comparison).
    """

    block_px: int = 31
    contrast: float = 12.0
    min_area_px: int = 8
    area_ratio: tuple[float, float] = (0.3, 2.2)
    max_aspect: float = 2.5
    min_fill: float = 0.45
    max_brightness_ratio: float = 1.35
    split_touching: bool = True
    dark_pins: bool = False
    integer_centroids: bool = False

    def __post_init__(self) -> None:
        checks = {
            "block_px": (self.block_px >= 3 and self.block_px % 2 == 1, "an odd number of pixels from 3 up"),
            "contrast": (0 < self.contrast < 255, "grey levels between 0 and 255"),
            "min_area_px": (self.min_area_px >= 1, "at least one pixel"),
            "area_ratio": (0 <= self.area_ratio[0] < 1 < self.area_ratio[1], "(below 1, above 1)"),
            "max_aspect": (self.max_aspect >= 1, "1 or more"),
            "min_fill": (0 <= self.min_fill < 1, "a share from 0 to below 1"),
            "max_brightness_ratio": (self.max_brightness_ratio > 1, "above 1"),
        }
        for name, (good, wanted) in checks.items():
            if not good:
                found = repr(getattr(self, name))
                raise SettingError(f"PinSettings.{name}", wanted=wanted, found=found, do="Choose a value in that range.")


@dataclass(frozen=True)
class Pins:
    """Pins of one frame: centroids (N, 2) x, y px, top to bottom and left to right; areas (N,) px; what was left out."""

    centroids_px: NDArray[np.float64]
    area_px: NDArray[np.float64]
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.centroids_px)


def detect_pins(image: NDArray[Any], settings: PinSettings | None = None) -> Pins:
    """Pins of one frame, grey, colour or binary.

    Raises
    ------
    PinsError : fewer than three pins. ImageError : not an image.
    """
    settings = settings or PinSettings()
    return find_pins(pins_bright(image, settings), settings)


def pins_bright(image: NDArray[Any], settings: PinSettings) -> Grey:
    """The frame as grey levels in which the pins are the bright part."""
    grey = as_grey(image)
    return 255 - grey if settings.dark_pins else grey


def find_pins(grey: Grey, settings: PinSettings) -> Pins:
    """``detect_pins`` on a frame that went through ``pins_bright``."""
    excess, mask = above_surroundings(grey, settings.block_px, settings.contrast)
    blobs = find_blobs(excess, mask)
    blobs = blobs.pick(blobs.area_px >= settings.min_area_px)
    if not 3 <= len(blobs) <= MOST_BLOBS:
        raise _no_pins(grey, len(blobs), settings)
    seeds, notes = _seeds(blobs, excess, mask, settings)
    if len(seeds) < 3:
        raise _no_pins(grey, len(seeds), settings)
    reach = reach_of(nearest_pins(seeds, 1)[0][:, 0], float(np.median(blobs.area_px)))
    spots = measure_spots(grey, seeds, reach)
    order = np.lexsort((spots.centroids_px[:, 0], spots.centroids_px[:, 1]))
    centroids = spots.centroids_px[order]
    return Pins(np.trunc(centroids) if settings.integer_centroids else centroids, spots.area_px[order], notes)


def reach_of(neighbour_px: NDArray[np.float64], pin_area_px: float) -> NDArray[np.float64]:
    """Radius around a pin that holds the whole pin and nothing of the next one: half way, but no more than needed."""
    return np.minimum(0.5 * neighbour_px, np.sqrt(pin_area_px / np.pi) + 4.0)


def _seeds(
    blobs: Blobs, excess: Grey, mask: NDArray[np.uint8], settings: PinSettings
) -> tuple[NDArray[np.float64], tuple[str, ...]]:
    """Rough pin centres (N, 2) and notes on what was dropped or split."""
    low, high = settings.area_ratio
    ratio = blobs.area_px / np.median(blobs.area_px)
    sides = blobs.box[:, 2:]
    fill = blobs.area_px / sides.prod(axis=1)
    aspect = sides.max(axis=1) / sides.min(axis=1)
    size_ok = (ratio >= low) & (ratio <= high)
    round_ok = (fill >= settings.min_fill) & (aspect <= settings.max_aspect)
    dim = ~_brighter_than_neighbours(blobs, size_ok & round_ok, settings.max_brightness_ratio)
    keep = size_ok & round_ok & dim
    seeds = blobs.centres_px[keep]
    notes = [f"{n} blobs left out: {why}" for n, why in _reasons(ratio, low, high, round_ok, dim, size_ok)]
    if settings.split_touching:
        seeds, split = _split(blobs, (ratio > 1.6) & (ratio < 8.0) & dim, keep, excess, mask)
        notes += [f"{split} blobs were pins that touch and were split"] if split else []
    return seeds, tuple(notes)
