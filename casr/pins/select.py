"""Which blobs are pins: by size, shape and brightness against the other pins; touching pins are taken apart."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from casr.pins.blobs import Blobs, round_parts
from casr.pins.lattice import squared_distance
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
    pin_sized = (ratio >= low) & (ratio <= high)
    glare = _glare(blobs, pin_sized & pin_shaped, settings.max_brightness_ratio)
    single = pin_sized & pin_shaped & ~glare
    seeds = [blobs.centres_px[single]]
    n_split = 0
    for row in np.flatnonzero((ratio > settings.touching_ratio) & (ratio <= settings.most_touching * high) & ~glare):
        parts = round_parts(mask, blobs.box[row])
        if len(parts) >= 2 and low <= ratio[row] / len(parts) <= high:
            seeds.append(parts)
            single[row], n_split = False, n_split + 1
    seeds[0] = blobs.centres_px[single]
    return np.concatenate(seeds), _notes(n_split, int(glare.sum()), len(blobs) - int(single.sum()) - n_split)


def _glare(blobs: Blobs, plausible: NDArray[np.bool_], most: float) -> NDArray[np.bool_]:
    """Lamps and reflections: over ``most`` times as bright as the pins around, in itself or above its surroundings."""
    glare = np.zeros(len(blobs), bool)
    pins = np.flatnonzero(plausible)
    if pins.size <= NEIGHBOURS:
        return glare
    for light in (blobs.brightness, blobs.excess):
        bright = np.flatnonzero(light > most * light[pins].min())
        if bright.size:
            squared = squared_distance(blobs.centres_px[bright], blobs.centres_px[pins])
            squared[bright[:, None] == pins] = np.inf
            around = pins[np.argpartition(squared, NEIGHBOURS - 1, axis=1)[:, :NEIGHBOURS]]
            glare[bright] |= light[bright] > most * np.median(light[around], axis=1)
    return glare


def _notes(n_split: int, n_glare: int, n_out: int) -> tuple[str, ...]:
    notes = []
    if n_out:
        notes.append(f"{n_out} bright blobs left out, {n_glare} of them as glare")
    if n_split:
        notes.append(f"{n_split} blobs were touching pins and were split")
    return tuple(notes)
