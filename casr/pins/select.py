"""Which blobs are pins: by size, shape and brightness against the other pins; touching pins are taken apart."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from casr.pins.blobs import Blobs, round_parts
from casr.pins.lattice import nearest_pins
from casr.pins.settings import PinSettings

NEIGHBOURS = 6  # in a hexagonal lattice


def select_pins(
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
