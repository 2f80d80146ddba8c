"""Find the pins of one frame to sub-pixel accuracy (Algorithm 1, steps 1 and 2: shape and colour masks, centroids)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from casr.errors import PinsError
from casr.images import Grey, as_grey
from casr.pins.blobs import above_surroundings, find_blobs
from casr.pins.lattice import nearest_pins
from casr.pins.select import select_pins
from casr.pins.settings import PinSettings
from casr.pins.spots import measure_spots

FEWEST_PINS, MOST_BLOBS = 3, 3000
REACH_OF_SPACING = 0.43


@dataclass(frozen=True)
class Pins:
    """Pins of one frame, top to bottom: centroids (N, 2) x, y px; areas (N,) px; notes on what was left out, split."""

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
    pins = find_pins(pins_bright(image, settings), settings)
    return replace(pins, centroids_px=reported_px(pins.centroids_px, settings))


def pins_bright(image: NDArray[Any], settings: PinSettings) -> Grey:
    """The frame as grey levels in which the pins are the bright part."""
    grey = as_grey(image)
    return 255 - grey if settings.dark_pins else grey


def find_pins(grey: Grey, settings: PinSettings) -> Pins:
    """Sub-pixel pins of a frame that went through ``pins_bright``."""
    _check_count(grey, min(grey.size, FEWEST_PINS), settings)  # OpenCV refuses to compare a single pixel
    excess, mask = above_surroundings(grey, settings.block_px, settings.contrast)
    blobs = find_blobs(grey, excess, mask)
    blobs = blobs.pick(blobs.area_px >= settings.min_area_px)
    _check_count(grey, len(blobs), settings)
    seeds, notes = select_pins(blobs, mask, settings)
    _check_count(grey, len(seeds), settings)
    spots = measure_spots(grey, seeds, reach_px(nearest_pins(seeds, 1)[0][:, 0]))
    # where pins stand too close to see any background between them, the blob's own centre has to do
    centroids = np.where(np.isfinite(spots.centroids_px), spots.centroids_px, seeds)
    order = np.lexsort((centroids[:, 0], centroids[:, 1]))
    return Pins(centroids[order], spots.area_px[order], notes)


def reported_px(centroids_px: NDArray[np.float64], settings: PinSettings) -> NDArray[np.float64]:
    """Centroids as they leave this package: sub-pixel, or cut as the paper's ``int()`` does."""
    return np.trunc(centroids_px) if settings.integer_centroids else centroids_px


def reach_px(spacing_px: NDArray[np.float64]) -> NDArray[np.float64]:
    """Radius around each pin that holds all of it and nothing of the next one, from the distance (N,) to that one."""
    reach: NDArray[np.float64] = REACH_OF_SPACING * np.minimum(spacing_px, np.median(spacing_px))
    return reach


def _check_count(grey: Grey, n: int, settings: PinSettings) -> None:
    if FEWEST_PINS <= n <= MOST_BLOBS:
        return
    low, high = float(grey.min()), float(grey.max())
    if high - low <= settings.contrast:
        do = "The frame is nearly uniform: check light, lens cap, exposure, and that grey levels run to 255, not to 1."
    elif n > MOST_BLOBS:
        do = "Raise PinSettings.contrast or min_area_px: the frame is too noisy for these settings."
    else:
        do = "Lower PinSettings.contrast or min_area_px, set block_px to 1.5 pin pitches, or dark_pins for dark pins."
    raise PinsError(
        "frame",
        wanted=f"{FEWEST_PINS} to {MOST_BLOBS} pins on grey levels",
        found=f"{n} bright blobs that could be pins, grey levels {low:.0f} to {high:.0f}",
        do=do,
    )
