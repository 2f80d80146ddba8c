"""Follow pins from frame to frame: each keeps its row for ever, is NaN while lost and comes back to its row."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from casr.errors import PinsError
from casr.images import Grey
from casr.pins.detect import Pins, find_pins, pins_bright, reach_px
from casr.pins.lattice import nearest_pins
from casr.pins.propagate import common_shift_px, follow_neighbours, links_of, neighbour_mean
from casr.pins.settings import PinSettings
from casr.pins.spots import Spots, measure_spots

NEIGHBOURS = 6  # in a hexagonal lattice
LONGEST_LOOK = 0.25  # of the spacing: further than this from where it was expected, a pin may be taken for the next one
IN_PLACE = 0.8  # share of the pins seen where they are expected, from which on the others are lost and not displaced
AREA_CHANGE = 2.0  # a pin does not grow or shrink by more from one frame to the next

Points = NDArray[np.float64]
Mask = NDArray[np.bool_]


class PinTracker:
    """Pins followed through a sequence; ids are the row numbers of the pins that ``start`` returns.

    A step looks for each pin around the place its last motion leads to and reads only those pixels. Where a pin
    vanishes, parts from its neighbours, or all jump by more than a quarter of the pitch, the whole frame is searched
    and the motion handed on from pin to pin (``follow_neighbours``).

    Attributes
    ----------
    pitch_px : pin spacing in the first frame; NaN before ``start``.
    """

    def __init__(self, settings: PinSettings | None = None) -> None:
        self.pitch_px = float("nan")
        self._settings = settings or PinSettings()
        self._n = 0

    def start(self, image: NDArray[Any]) -> Pins:
        """Detect the pins of the first frame. Raises PinsError, ImageError as ``detect_pins``."""
        self._frame = pins_bright(image, self._settings).copy()
        pins = find_pins(self._frame, self._settings)
        self._n = len(pins)
        self._ids = self._wanted = np.arange(self._n)
        self._place_px = pins.centroids_px.copy()  # where each pin is or, while it is lost, should be
        self._move_px = np.zeros_like(self._place_px)
        self._area_px = pins.area_px.copy()
        self._lost = np.zeros(self._n, bool)
        self._link()
        self.pitch_px = float(np.median(self._spacing_px))
        return pins

    def restrict(self, ids: Sequence[int] | NDArray[np.integer[Any]]) -> None:
        """From now on follow these pins (and those next to them, to know where each ends); all others stay NaN.

        Raises PinsError for ids that are not followed, or before ``start``.
        """
        self._need_start()
        wanted = np.unique(np.asarray(ids, np.intp))
        if wanted.size < 2 or not np.isin(wanted, self._ids).all():
            raise PinsError(
                "PinTracker.restrict",
                wanted="ids of two or more pins that are being followed",
                found=f"{wanted.tolist()}",
                do=f"Use row numbers below {self._n} of the pins that start() returned.",
            )
        rows = np.flatnonzero(np.isin(self._ids, wanted))
        rows = np.union1d(rows, self._beside[rows])
        self._ids, self._wanted = self._ids[rows], wanted
        self._place_px, self._move_px = self._place_px[rows], self._move_px[rows]
        self._area_px, self._lost = self._area_px[rows], self._lost[rows]
        self._link()

    def step(self, image: NDArray[Any]) -> Points:
        """Positions (N, 2) px of all pins in the next frame, row by id; NaN where a pin is lost or not followed.

        Raises PinsError before ``start`` or for a frame of another size, ImageError as ``as_grey``.
        """
        self._need_start()
        grey = pins_bright(image, self._settings)
        if grey.shape != self._frame.shape or grey.dtype != self._frame.dtype:
            raise PinsError(
                "frame",
                wanted=f"size and type of the first frame, {self._frame.shape} {self._frame.dtype}",
                found=f"{grey.shape} {grey.dtype}",
                do="Start a new tracker when the camera's format changes.",
            )
        if not np.array_equal(grey, self._frame):  # a repeated frame moves nothing, to the last bit
            self._frame = grey.copy()
            self._advance(grey)
        positions = np.full((self._n, 2), np.nan)
        positions[self._ids[~self._lost]] = self._place_px[~self._lost]
        wanted = np.full_like(positions, np.nan)
        wanted[self._wanted] = positions[self._wanted]
        return wanted

    def _link(self) -> None:
        """Who is beside whom, how far, and how bright against them."""
        self._beside = nearest_pins(self._place_px, NEIGHBOURS)[1]
        self._links = links_of(self._beside)
        self._spacing_px = _gaps_px(self._place_px, self._beside).min(axis=1)
        self._shine = self._shine_of(measure_spots(self._frame, self._place_px, reach_px(self._spacing_px)))

    def _advance(self, grey: Grey) -> None:
        """Find all pins in the next frame and keep places, motions and areas for the one after."""
        before, expected = self._place_px, self._place_px + self._move_px
        place, area, seen = self._look(grey, expected)
        if (~seen & ~self._lost).any() or _median_length(place - expected) > LONGEST_LOOK * self.pitch_px:
            # part of a lattice, without its edge, fits itself one pitch further: if most are in place, none has jumped
            in_place = len(seen) < self._n and seen.mean() > IN_PLACE
            place, area, seen = self._search(grey, expected, in_place)
        self._place_px = np.where(seen[:, None], place, before + neighbour_mean(place - before, seen, self._links))
        self._move_px = self._place_px - before
        self._area_px = np.where(seen, area, self._area_px)
        self._lost = ~seen
        self._spacing_px = _gaps_px(self._place_px, self._beside).min(axis=1)

    def _look(self, grey: Grey, expected: Points) -> tuple[Points, NDArray[np.float64], Mask]:
        """Place, area and whether seen, of each pin, from the pixels around where it is expected."""
        spots = measure_spots(grey, expected, reach_px(self._spacing_px))
        area = spots.area_px
        seen = (spots.contrast >= self._settings.contrast) & ~self._in_glare(spots)
        seen &= (area < AREA_CHANGE * self._area_px) & (area * AREA_CHANGE > self._area_px)
        place = np.where(seen[:, None], spots.centroids_px, expected)
        move = place - self._place_px
        apart = move - neighbour_mean(move, seen, self._links)
        seen &= np.hypot(apart[:, 0], apart[:, 1]) <= LONGEST_LOOK * self._spacing_px
        return place, area, seen & ~self._taken_twice(place, expected)

    def _taken_twice(self, place: Points, expected: Points) -> Mask:
        """Pins that sit on a neighbour with the better claim: not lost before, then nearer to where it was expected."""
        same = _gaps_px(place, self._beside) < np.sqrt(self._area_px / np.pi)[:, None]
        if not same.any():
            return np.zeros(len(place), bool)
        rank = np.lexsort((np.hypot(*(place - expected).T), self._lost)).argsort()
        return np.asarray((same & (rank[:, None] > rank[self._beside])).any(axis=1))

    def _search(self, grey: Grey, expected: Points, in_place: bool) -> tuple[Points, NDArray[np.float64], Mask]:
        """Place, area and whether seen, of each pin, from all pins of the frame."""
        try:
            pins = find_pins(grey, self._settings)
        except PinsError:
            return expected, self._area_px, np.zeros(len(expected), bool)
        guesses = [expected]
        if not in_place:
            pitch_px = float(np.median(self._spacing_px))
            guesses += [self._place_px, self._place_px + common_shift_px(self._place_px, pins.centroids_px, pitch_px)]
        rows = follow_neighbours(self._place_px, guesses, pins.centroids_px, self._links, self._spacing_px)
        seen = rows >= 0
        place = np.where(seen[:, None], pins.centroids_px[rows], expected)
        seen &= ~self._in_glare(measure_spots(grey, place, reach_px(self._spacing_px)))
        return place, np.where(seen, pins.area_px[rows], self._area_px), seen

    def _in_glare(self, spots: Spots) -> Mask:
        """Pins that outshine those beside them far more than at first: a reflection draws their centroids to itself."""
        return np.asarray(self._shine_of(spots) > self._settings.max_brightness_ratio * self._shine)

    def _shine_of(self, spots: Spots) -> NDArray[np.float64]:
        """Contrast of each pin over that of the pins beside it."""
        beside = np.sort(spots.contrast[self._beside], axis=1)[:, self._beside.shape[1] // 2]
        return np.asarray(spots.contrast / np.maximum(beside, self._settings.contrast))

    def _need_start(self) -> None:
        if not self._n:
            raise PinsError("PinTracker", wanted="start(image) first", found="no first frame", do="Call start once.")


def _gaps_px(place: Points, beside: NDArray[np.intp]) -> NDArray[np.float64]:
    """Distance (n, k) of each pin to the pins beside it."""
    x, y = place[:, 0], place[:, 1]
    dx, dy = x[:, None] - x[beside], y[:, None] - y[beside]
    gaps: NDArray[np.float64] = np.sqrt(dx * dx + dy * dy)
    return gaps


def _median_length(vectors: Points) -> float:
    lengths = np.hypot(vectors[:, 0], vectors[:, 1])
    return float(np.partition(lengths, len(lengths) // 2)[len(lengths) // 2])
