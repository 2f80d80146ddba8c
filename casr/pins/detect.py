"""Find the pins of one frame to sub-pixel accuracy (Algorithm 1, steps 1 and 2: shape and colour masks, centroids)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from casr.errors import PinsError
from casr.images import Grey, as_grey
from casr.pins.blobs import Blobs, above_surroundings, find_blobs, round_parts
from casr.pins.lattice import nearest_pins
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
    return find_pins(pins_bright(image, settings), settings)


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
    seeds, notes = _select_pins(blobs, mask, settings)
    _check_count(grey, len(seeds), settings)
    spots = measure_spots(grey, seeds, reach_px(nearest_pins(seeds, 1)[0][:, 0]))
    # where pins stand too close to see any background between them, the blob's own centre has to do
    centroids = np.where(np.isfinite(spots.centroids_px), spots.centroids_px, seeds)
    order = np.lexsort((centroids[:, 0], centroids[:, 1]))
    return Pins(centroids[order], spots.area_px[order], notes)


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


NEIGHBOURS = 6  # in a hexagonal lattice


def _select_pins(
    blobs: Blobs, mask: NDArray[np.uint8], settings: PinSettings
) -> tuple[NDArray[np.float64], tuple[str, ...]]:
    """Rough centres (N, 2) px of the pins among the blobs, and notes on what was left out or split."""
    low, high = settings.area_ratio
    ratio = blobs.area_px / np.median(blobs.area_px)
    sides = blobs.box[:, 2:]
    pin_shaped = (blobs.area_px >= settings.min_fill * sides.prod(axis=1)) & (
        sides.max(axis=1) <= settings.max_aspect * sides.min(axis=1)
    )
    single = (ratio >= low) & (ratio <= high) & pin_shaped
    touching = (ratio > settings.touching_ratio) & (ratio <= settings.most_touching * high)
    glare = _glare(blobs, np.flatnonzero(single | touching), settings.max_brightness_ratio)
    single &= ~glare
    parts_of = {row: round_parts(mask, blobs.box[row]) for row in np.flatnonzero(touching & ~glare)}
    split = {row: parts for row, parts in parts_of.items() if len(parts) > 1 and ratio[row] >= low * len(parts)}
    single[list(split)] = False
    n_out = len(blobs) - int(single.sum()) - len(split)
    seeds = np.concatenate([blobs.centres_px[single], *split.values()])
    return seeds, _notes(len(split), int(glare.sum()), n_out)


def _glare(blobs: Blobs, rows: NDArray[np.intp], most: float) -> NDArray[np.bool_]:
    """Lamps and reflections: over ``most`` times as bright as the blobs around, in itself or above its surroundings."""
    glare = np.zeros(len(blobs), bool)
    if rows.size <= NEIGHBOURS:
        return glare
    lights = [light for light in (blobs.brightness, blobs.excess) if light[rows].max() > most * light[rows].min()]
    if not lights:
        return glare
    around = rows[nearest_pins(blobs.centres_px[rows], NEIGHBOURS)[1]]
    for light in lights:
        glare[rows] |= light[rows] > most * np.median(light[around], axis=1)
    return glare


def _notes(n_split: int, n_glare: int, n_out: int) -> tuple[str, ...]:
    notes = []
    if n_out:
        notes.append(f"{n_out} bright blobs left out, {n_glare} of them as glare")
    if n_split:
        notes.append(f"{n_split} blobs were touching pins and were split")
    return tuple(notes)
