"""Find the pins of one frame to sub-pixel accuracy (Algorithm 1, steps 1 and 2: shape and colour masks, centroids)."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.counts import count
from casr.errors import PinsError
from casr.images import Grey, as_grey
from casr.median import median
from casr.pins.lattice import NEIGHBOURS, nearest_pins
from casr.pins.spots import measure_spots
from casr.pins.view import FEWEST_PINS, USUAL_CONTRAST, USUAL_PITCH_PX, PinSettings, PinView, guess_pitch_px

WAIST = 0.65  # where pins touch, the blob is narrower than this share of their width


@dataclass(frozen=True)
class Blobs:
    """(n,) blobs: box (n, 4) x, y, width, height; area px; mean grey level; its mean excess over the surroundings."""

    box: NDArray[np.int32]
    area_px: NDArray[np.int32]
    brightness: NDArray[np.float64]
    excess: NDArray[np.float64]
    centres_px: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.area_px)

    def pick(self, rows: NDArray[np.intp] | NDArray[np.bool_]) -> Blobs:
        """The blobs of these rows: (k,) indices, or (n,) true and false."""
        return Blobs(*(getattr(self, field.name)[rows] for field in fields(self)))


def above_surroundings(image: Grey, block_px: int, contrast: float) -> tuple[Grey, NDArray[np.uint8]]:
    """Grey levels (H, W) above the mean of the ``block_px`` square around each pixel, and mask of those above
    ``contrast``."""
    excess = cast(Grey, cv2.subtract(image, cv2.blur(image, (block_px, block_px))))
    return excess, _over(excess, contrast)


def find_blobs(image: Grey, excess: Grey, mask: NDArray[np.uint8]) -> Blobs:
    """Connected pieces (8 neighbours) of ``mask`` that do not touch the border of the image."""
    n, labels, stats, centres = cv2.connectedComponentsWithStatsWithAlgorithm(mask, 8, cv2.CV_32S, cv2.CCL_GRANA)
    pixels = np.flatnonzero(mask.ravel().view(np.bool_))
    label = labels.ravel()[pixels]
    box, area = cast(NDArray[np.int32], stats[:, :4]), cast(NDArray[np.int32], stats[:, cv2.CC_STAT_AREA])
    brightness, over = (np.bincount(label, grey.ravel()[pixels], minlength=n) / area for grey in (image, excess))
    height, width = mask.shape
    inside = (box[:, :2] > 0).all(axis=1) & (box[:, 0] + box[:, 2] < width) & (box[:, 1] + box[:, 3] < height)
    inside[0] = False
    return Blobs(box, area, brightness, over, cast(NDArray[np.float64], centres)).pick(inside)


def round_parts(mask: NDArray[np.uint8], box: NDArray[np.int32]) -> NDArray[np.float64]:
    """Centres (k, 2) of the round parts of the blob in ``box``: 1 for a single pin, more for pins that touch."""
    x, y, width, height = (int(v) for v in box)
    piece = np.pad(mask[y : y + height, x : x + width], 1)
    depth = cv2.distanceTransform(piece, cv2.DIST_L2, 5)
    cores = _over(depth, WAIST * float(depth.max()))
    n, _, _, centres = cv2.connectedComponentsWithStats(cores, connectivity=8)
    parts: NDArray[np.float64] = np.asarray(centres, np.float64)[1:n] + np.array([x - 1.0, y - 1.0])
    return parts


def _over(values: NDArray[Any], level: float) -> NDArray[np.uint8]:
    """255 where the values exceed the level, else 0."""
    return cast(NDArray[np.uint8], cv2.compare(values, level, cv2.CMP_GT))  # type: ignore[call-overload]


MOST_BLOBS = 3000
REACH_OF_SPACING = 0.43
USUAL_SIDE_PX = 1000  # frames up to this are first looked at as if pins had the usual pitch, which is quick
REGULAR = 1.3  # third over first quartile of the distances to the nearest pin: 1.03 in a lattice at rest, 1.8 in noise


@dataclass(frozen=True)
class Pins:
    """Pins of one frame, top to bottom: centroids (N, 2) x, y px; areas (N,) px; notes on what was left out, split."""

    centroids_px: NDArray[np.float64]
    area_px: NDArray[np.float64]
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        notes = f", {len(self.notes)} notes" if self.notes else ""
        return f"Pins({len(self)} pins, median area {np.median(self.area_px):.3g} px{notes})"

    def __len__(self) -> int:
        return len(self.centroids_px)


def detect_pins(image: NDArray[Any], settings: PinSettings | None = None) -> Pins:
    """Pins of one frame (H, W) or (H, W, 3), grey, colour or binary (paper, Algorithm 1, steps 1 and 2).

    PinsError : fewer than three pins. ImageError : not an image.
    """
    view, pins = fit_view(image, settings or PinSettings())
    return Pins(view.in_frame(pins.centroids_px), pins.area_px * view.reduction**2, pins.notes)


def fit_view(image: NDArray[Any], settings: PinSettings) -> tuple[PinView, Pins]:
    """How to look at frames like this one (H, W) or (H, W, 3), and its pins in px of that view.

    Pins of the pitch that the settings say; else of the usual one or, where those found stand in no order, of the one
    that the frame repeats itself with, whichever gives the more regular pins.
    PinsError : fewer than three pins. ImageError : not an image.
    """
    grey = as_grey(image)
    if settings.pitch_px is not None:
        return _found(grey, settings.pitch_px, settings)
    usual = _attempt(grey, USUAL_PITCH_PX, settings) if max(grey.shape) <= USUAL_SIDE_PX else None
    if usual is not None and _irregularity(usual[1]) <= REGULAR:
        return usual
    pitch_px = guess_pitch_px(grey)
    guessed = None if pitch_px is None else _attempt(grey, pitch_px, settings)
    attempts = [attempt for attempt in (usual, guessed) if attempt is not None]
    if not attempts:
        return _found(grey, pitch_px or USUAL_PITCH_PX, settings)
    return min(attempts, key=lambda attempt: _irregularity(attempt[1]))


def _found(grey: Grey, pitch_px: float, settings: PinSettings) -> tuple[PinView, Pins]:
    view = PinView.of_pitch(grey, pitch_px, settings)
    return view, find_pins(view.grey(grey), view)


def _attempt(grey: Grey, pitch_px: float, settings: PinSettings) -> tuple[PinView, Pins] | None:
    try:
        return _found(grey, pitch_px, settings)
    except PinsError:
        return None


def _irregularity(pins: Pins) -> float:
    """Third over first quartile of the distances to the nearest pin; lattices have nearly 1."""
    first, third = np.percentile(nearest_pins(pins.centroids_px, 1)[0], [25, 75])
    return float(third / max(first, 1e-9))


def find_pins(grey: Grey, view: PinView) -> Pins:
    """Sub-pixel pins of a frame (H, W) that went through ``view.grey``, in its px (paper, Algorithm 1, steps 1 and 2).

    PinsError : fewer than three.
    """
    _check_count(grey, min(grey.size, FEWEST_PINS), view)  # OpenCV refuses to compare a single pixel
    count("pixels weighed", grey.size)
    excess, mask = above_surroundings(grey, view.block_px, view.contrast)
    blobs = find_blobs(grey, excess, mask)
    blobs = blobs.pick(blobs.area_px >= view.min_area_px)
    _check_count(grey, len(blobs), view)
    seeds, notes = _select_pins(blobs, mask, view.settings)
    _check_count(grey, len(seeds), view)
    spots = measure_spots(grey, seeds, reach_px(nearest_pins(seeds, 1)[0][:, 0]))
    # where pins stand too close to see any background between them, the blob's own centre has to do
    centroids = np.where(np.isfinite(spots.centroids_px), spots.centroids_px, seeds)
    order = np.lexsort((centroids[:, 0], centroids[:, 1]))
    return Pins(centroids[order], spots.area_px[order], notes)


def reach_px(spacing_px: NDArray[np.float64]) -> NDArray[np.float64]:
    """Radius around each pin that holds all of it and nothing of the next one, from the distance (N,) to that one."""
    reach: NDArray[np.float64] = REACH_OF_SPACING * np.minimum(spacing_px, median(spacing_px))
    return reach


def _check_count(grey: Grey, n: int, view: PinView) -> None:
    if FEWEST_PINS <= n <= MOST_BLOBS:
        return
    low, high = float(grey.min()), float(grey.max())
    if high - low <= min(view.contrast, USUAL_CONTRAST):
        do = "The frame is nearly uniform: check light, lens cap, exposure, and that grey levels run to 255, not to 1."
    elif n > MOST_BLOBS:
        do = "The frame is too noisy: raise the contrast (--contrast) or the least area of a pin (--min-area)."
    else:
        do = (
            "Lower the contrast (--contrast) or the least area of a pin (--min-area), say the pin pitch (--pitch), "
            "or that pins are dark (--dark-pins)."
        )
    raise PinsError(
        "frame", wanted=f"{FEWEST_PINS} to {MOST_BLOBS} pins on grey levels",
        found=f"{n} bright blobs that could be pins, grey levels {low:.0f} to {high:.0f}", do=do,
    )  # fmt: skip


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
