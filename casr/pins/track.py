"""Follow pins from frame to frame: each keeps its row for ever, is NaN while lost and comes back to its row."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from casr.errors import PinsError
from casr.images import Grey
from casr.median import median
from casr.pins.detect import Pins, find_pins, fit_view, reach_px
from casr.pins.lattice import NEIGHBOURS, at_border, nearest_pins
from casr.pins.propagate import Neighbours, common_shifts_px, neighbour_mean
from casr.pins.spots import Spots, measure_spots
from casr.pins.view import PinSettings, line_noise, noisy_share

LONGEST_LOOK = 0.25  # of the spacing: further than this from where it was expected, a pin may be taken for the next one
AREA_CHANGE = 2.0  # a pin does not grow or shrink by more from one frame to the next
ONE_SIDE = 0.5  # of the root of the number of pins: so many vanish at once where a lattice slips by a pitch
RARELY = 10  # frames after which a single pin is worth another search
BELIEVED_SHARE, LIKELY_SHARE = 0.5, 0.75  # of the pins seen before that a frame must show: always; at first sight
MOST_DOUBTED = 2  # frames in a row; what stays so is no accident
JUMPED_SHARE = 0.98  # the same where all jump by half a pitch: of a torn lattice parts fit one pitch further
APART_SHARE, APART_PITCHES = 0.1, 0.06  # so many pins farther from where those around them went are torn off,
FAR_APART_PITCHES = 0.2  # if all along one line; the quickest unloading has 0.1, everywhere; and by so much always
ONE_WAY = 0.3  # mean square across a direction over that along it: a tear shifts along one, a contact spreads to all
NOISY_GREY, NOISY_TIMES, NOISY_LINES = 5.0, 3.0, 0.1  # noise over so many times that at first, on a share of the lines
KNOCK_NOTE = (
    "all pins jump alike by over half their pitch, those at the border too: a knock of the camera, which is taken out; "
    "if there are many, are these frames one press, in order?"
)
KNOCK_PITCHES, KNOCK_SCATTER = 0.5, 0.2  # by how much the border jumps at a knock; how far its pins may differ, pitches

Points = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class _Places:
    """Where each pin is or, while it is lost, should be; its motion in the last step; its area; whether it is lost."""

    at_px: Points
    move_px: Points
    area_px: NDArray[np.float64]
    lost: Mask


class PinTracker:
    """Pins followed through a sequence; ids are the row numbers of the pins that ``start`` returns.

    A step looks for each pin around the place its last motion leads to and reads only those pixels. Where so many
    vanish as stand on one side of the array, or all jump by more than a quarter of the pitch, the whole frame is
    searched and the motion handed on from pin to pin (``Neighbours``); for single pins only every tenth frame.

    A frame that shows fewer than half of the pins seen before, or noise in their place, is not believed: no pin has a
    place in it, and the next frame is looked at as if it had not been. The same befalls one in which over a quarter of
    the pins vanish, or a few while all jump, or in which many part from those around them as where a frame is torn,
    unless it is the first, or the two before were not believed either: what stays so is no accident.

    pitch_px : pin spacing in the first frame; NaN before ``start``.
    knock_px : (2,) how far knocks have moved the image since the first frame. A knock is a jump of the pins at the
        border of the array, all alike, by more than half a pitch between two frames: the border is what a contact moves
        last. The places of the pins are those in the image; without the knocks they are places - knock_px.
    first_px : (N, 2) places in the first frame. notes : what a reader should know of the last step.
    """

    def __init__(self, settings: PinSettings | None = None) -> None:
        self.pitch_px = float("nan")
        self.knock_px = np.zeros(2)
        self.notes: tuple[str, ...] = ()
        self._settings = settings or PinSettings()
        self._started = False

    def start(self, image: NDArray[Any]) -> Pins:
        """Detect the pins of the first frame (H, W) or (H, W, 3). Raises PinsError, ImageError as ``detect_pins``."""
        self._view, pins = fit_view(image, self._settings)
        self._frame = self._view.grey(image).copy()
        n = len(pins)
        at_px = pins.centroids_px.copy()
        self._places = _Places(at_px, np.zeros_like(at_px), pins.area_px.copy(), np.zeros(n, bool))
        self._beside = nearest_pins(at_px, NEIGHBOURS)[1]
        self._border = at_border(at_px, self._beside)
        self._spacing_px = _gaps_px(at_px, self._beside).min(axis=1)
        self._shine = self._shine_of(measure_spots(self._frame, at_px, reach_px(self._spacing_px)))
        self._pitch_px = float(np.median(self._spacing_px))
        self._most_noise = max(NOISY_GREY, NOISY_TIMES * float(np.median(line_noise(self._frame))))
        self._since_search = RARELY
        self._doubted = MOST_DOUBTED  # before the first step anything may have happened
        self.pitch_px = self._pitch_px * self._view.reduction
        self.knock_px, self.notes = np.zeros(2), ()
        self._started = True
        self.first_px, scale = self._view.in_frame(pins.centroids_px), self._view.reduction
        return replace(pins, centroids_px=self.first_px, area_px=pins.area_px * scale**2)

    def step(self, image: NDArray[Any]) -> Points:
        """Places (N, 2) px of all pins in the next frame, row by id; NaN where one is lost, all NaN for a bad frame.

        Raises PinsError before ``start`` or for a frame of another size, ImageError as ``as_grey``.
        """
        if not self._started:
            raise PinsError(
                "PinTracker", wanted="a first frame", found="none", do="Call start(image) before the first update."
            )
        grey = self._view.grey(image)
        if grey.shape != self._frame.shape or grey.dtype != self._frame.dtype:
            raise PinsError(
                "frame", wanted=f"size and type of the first frame, {self._frame.shape} {self._frame.dtype}",
                found=f"{grey.shape} {grey.dtype}", do="Start a new tracker when the camera's format changes.",
            )  # fmt: skip
        self.notes = ()
        if not np.array_equal(grey, self._frame):  # a repeated frame moves nothing, to the last bit
            places = self._advanced(grey)
            if not self._believed(grey, places):
                self._doubted += 1
                return np.full_like(places.at_px, np.nan)
            self._doubted = 0
            self._frame = grey.copy()
            self._places = self._without_knock(places)
            self._spacing_px = _gaps_px(places.at_px, self._beside).min(axis=1)
        return np.where(self._places.lost[:, None], np.nan, self._view.in_frame(self._places.at_px))

    def away_px(self, pins_px: Points) -> NDArray[np.float64]:
        """(n,) how far each pin seen at places (N, 2) of the last step is from the first frame, knocks taken off."""
        away_px = np.hypot(*(pins_px - self.knock_px - self.first_px).T)
        return np.asarray(away_px[np.isfinite(away_px)])

    def _believed(self, grey: Grey, places: _Places) -> bool:
        """Whether a frame is one of this press, and whole."""
        seen, n_before = ~places.lost, int((~self._places.lost).sum())
        if seen.sum() < BELIEVED_SHARE * n_before or noisy_share(grey, self._most_noise) > NOISY_LINES:
            return False
        if self._doubted >= MOST_DOUBTED:
            return True
        jumped = _median_length(places.move_px) > KNOCK_PITCHES * self._pitch_px
        likely = JUMPED_SHARE if jumped else LIKELY_SHARE
        return bool(seen.sum() >= likely * n_before) and not self._torn(places.move_px, seen)

    def _torn(self, move_px: Points, seen: Mask) -> bool:
        """Whether many pins part from those around them, along one line or very far."""
        apart = (move_px - neighbour_mean(move_px, seen, self._beside))[seen & ~self._border] / self._pitch_px
        most = APART_SHARE * len(apart)
        length = np.hypot(apart[:, 0], apart[:, 1])
        far = length > APART_PITCHES
        if (length > FAR_APART_PITCHES).sum() > most or not far.sum() > most:
            return bool((length > FAR_APART_PITCHES).sum() > most)
        across, along = np.linalg.eigvalsh(apart[far].T @ apart[far])
        return bool(across < ONE_WAY * along)

    def _advanced(self, grey: Grey) -> _Places:
        """All pins in the next frame."""
        before, last = self._places.at_px, self._places
        expected = before + last.move_px
        at_px, area, seen = self._look(grey, expected)
        if (~seen & ~last.lost).any():
            beside_px = before + neighbour_mean(at_px - before, seen, self._beside)
            at_px, area, seen = self._look(grey, np.where(seen[:, None], at_px, beside_px))
        vanished = int((~seen & ~last.lost).sum())
        most = 0 if self._since_search >= RARELY else ONE_SIDE * np.sqrt(len(seen))
        self._since_search += 1
        if vanished > most or _median_length(at_px - expected) > LONGEST_LOOK * self._pitch_px:
            at_px, area, seen = self._search(grey, expected)
            self._since_search = 0
        at_px = np.where(seen[:, None], at_px, before + neighbour_mean(at_px - before, seen, self._beside))
        return _Places(at_px, at_px - before, np.where(seen, area, last.area_px), ~seen)

    def _without_knock(self, places: _Places) -> _Places:
        """The same places, but a knock is no motion that goes on."""
        border = places.move_px[self._border & ~places.lost]
        if len(border) < NEIGHBOURS:
            return places
        shift = median(border)
        scatter = _median_length(border - shift)
        if np.hypot(*shift) <= KNOCK_PITCHES * self._pitch_px or scatter > KNOCK_SCATTER * self._pitch_px:
            return places
        self.knock_px = self.knock_px + shift * self._view.reduction
        self.notes = (KNOCK_NOTE,)
        return replace(places, move_px=places.move_px - shift)

    def _look(self, grey: Grey, expected: Points) -> tuple[Points, NDArray[np.float64], Mask]:
        """Place, area and whether seen, of each pin, from the pixels around where it is expected."""
        spots = measure_spots(grey, expected, reach_px(self._spacing_px))
        area, last = spots.area_px, self._places
        seen = (spots.contrast >= self._view.contrast) & ~self._in_glare(spots)
        seen &= (area < AREA_CHANGE * last.area_px) & (area * AREA_CHANGE > last.area_px)
        at_px = np.where(seen[:, None], spots.centroids_px, expected)
        move = at_px - last.at_px
        apart = move - neighbour_mean(move, seen, self._beside)
        seen &= np.hypot(apart[:, 0], apart[:, 1]) <= LONGEST_LOOK * self._spacing_px
        return at_px, area, seen & ~self._taken_twice(at_px, expected)

    def _taken_twice(self, at_px: Points, expected: Points) -> Mask:
        """Pins that sit on a neighbour with the better claim: not lost before, then nearer to where it was expected."""
        same = _gaps_px(at_px, self._beside) < np.sqrt(self._places.area_px / np.pi)[:, None]
        if not same.any():
            return np.zeros(len(at_px), bool)
        rank = np.lexsort((np.hypot(*(at_px - expected).T), self._places.lost)).argsort()
        return np.asarray((same & (rank[:, None] > rank[self._beside])).any(axis=1))

    def _search(self, grey: Grey, expected: Points) -> tuple[Points, NDArray[np.float64], Mask]:
        """Place, area and whether seen, of each pin, from all pins of the frame."""
        last = self._places
        try:
            pins = find_pins(grey, self._view)
        except PinsError:
            return expected, last.area_px, np.zeros(len(expected), bool)
        beside = Neighbours(last.at_px, pins.centroids_px, self._beside, self._spacing_px, self._frame.shape)

        def guesses() -> Iterator[Points]:
            yield expected
            yield last.at_px
            # a vote over all pairs, which mostly nobody needs
            yield from last.at_px + common_shifts_px(last.at_px, pins.centroids_px, self._pitch_px)[:, None]

        rows = beside.followed(guesses())
        seen = rows >= 0
        at_px = np.where(seen[:, None], pins.centroids_px[rows], expected)
        seen &= ~self._in_glare(measure_spots(grey, at_px, reach_px(self._spacing_px)))
        return at_px, np.where(seen, pins.area_px[rows], last.area_px), seen

    def _in_glare(self, spots: Spots) -> Mask:
        """Pins that outshine those beside them far more than at first: a reflection draws their centroids to itself."""
        return np.asarray(self._shine_of(spots) > self._view.settings.max_brightness_ratio * self._shine)

    def _shine_of(self, spots: Spots) -> NDArray[np.float64]:
        """Contrast of each pin over that of the pins beside it."""
        beside = np.sort(spots.contrast[self._beside], axis=1)[:, self._beside.shape[1] // 2]
        return np.asarray(spots.contrast / np.maximum(beside, self._view.contrast))


def _gaps_px(place: Points, beside: NDArray[np.intp]) -> NDArray[np.float64]:
    """Distance (n, k) of each pin to the pins beside it."""
    x, y = place[:, 0], place[:, 1]
    dx, dy = x[:, None] - x[beside], y[:, None] - y[beside]
    gaps: NDArray[np.float64] = np.sqrt(dx * dx + dy * dy)
    return gaps


def _median_length(vectors: Points) -> float:
    lengths = np.hypot(vectors[:, 0], vectors[:, 1])
    return float(np.partition(lengths, len(lengths) // 2)[len(lengths) // 2])
