"""The loading phase that the pins show where there is no force log."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from casr.errors import FramesError, NoContactError
from casr.frames import FrameSequence, LoadingPhase
from casr.pins import PinSettings, PinTracker
from casr.pins.lattice import on_lattice

TOUCHED_PINS = 3  # one pin may be a reflection, two on a line span no contact
OVER = 0.5  # of the farthest motion: below it the press is over
CHATTER_FRAMES = 3  # a touch of so few frames is none


class SeenLoading:
    """Finds the loading frame by frame: from the first touch to where the pins are farthest from rest.

    The first touch is the first frame in which three pins have moved more than ``threshold_px`` from where they are in
    frame 0. Loading ends at the frame in which the pins are farthest from rest on average; the press is over when
    they are back to half of that.

    threshold_px : of a touch. from_start : loading begins with frame 0, whatever touches.

    Attributes:
    first : frame where loading begins, None before. last : frame of the farthest pins since. over : the press is.
    """

    def __init__(self, threshold_px: float, *, from_start: bool = False) -> None:
        self._threshold_px, self._from_start = threshold_px, from_start
        self.first: int | None = 0 if from_start else None
        self.last, self.over = 0, False
        self._touched = False
        self._farthest_px = self._farthest_pin_px = 0.0
        self._most = 0

    def take(self, index: int, moved_px: NDArray[np.float64]) -> None:
        """The next frame after 0, and how far each pin seen in it is from its place in frame 0, (n,) px."""
        if moved_px.size == 0:
            return
        moved = int(np.sum(moved_px > self._threshold_px))
        self._farthest_pin_px = max(self._farthest_pin_px, float(moved_px.max()))
        self._most, self._touched = max(self._most, moved), self._touched or moved >= TOUCHED_PINS
        if self.first is None:
            if not self._touched:
                return
            self.first = index
        away_px = float(moved_px.mean())
        if away_px > self._farthest_px:
            self._farthest_px, self.last = away_px, index
        elif self._touched and away_px < OVER * self._farthest_px:
            if self.last - self.first >= CHATTER_FRAMES:
                self.over = True
            elif not self._from_start:
                self.first, self._farthest_px, self._touched = None, 0.0, False

    def phase(self, n_frames: int, rest_px: NDArray[np.float64]) -> LoadingPhase:
        """The loading of a recording of so many frames, with pins at (N, 2) in frame 0.

        NoContactError where nothing touches, FramesError where loading has fewer than two frames.
        """
        if self.first is None:
            raise self.nothing_touched(rest_px)
        if self.last <= self.first:
            raise FramesError(
                "loading phase", wanted="at least two frames in contact while the pins move away from rest",
                found=f"one, frame {self.first} of {n_frames}", do="Record on into the press.",
            )  # fmt: skip
        note = f"no force log: loading is taken from frame {self.first} to {self.last}, the pins' farthest from rest"
        frames = np.arange(self.first, self.last + 1)
        return LoadingPhase(0, frames, (f"{note} on average; there is no spread rate",))

    def nothing_touched(self, rest_px: NDArray[np.float64]) -> NoContactError:
        """What to say of the frames taken if nothing touches in them; pins at (N, 2) in frame 0."""
        do = "Begin with a frame at rest, lower threshold_px (--threshold-px), or give the region."
        if not on_lattice(rest_px):
            do = (
                "Frame 0 shows no lattice of pins: only sensors with pins can be scored. If it has some, help to find "
                "them (--pitch, --contrast, --min-area, --dark-pins)."
            )
        return NoContactError(
            "pins",
            wanted=f"{TOUCHED_PINS} pins that move more than {self._threshold_px:g} px from frame 0 in one frame",
            found=f"at most {self._most} of {len(rest_px)}; "
            f"the farthest that any moves is {self._farthest_pin_px:.2f} px", do=do,
        )  # fmt: skip


def first_touch(sequence: FrameSequence, threshold_px: float, pins: PinSettings | None = None) -> int:
    """The first frame in which three pins have moved more than ``threshold_px`` (px) from where they are in frame 0.

    NoContactError : there is none. PinsError : too few pins in frame 0.
    """
    tracker = PinTracker(pins)
    rest_px, seen = tracker.start(sequence[0]).centroids_px, SeenLoading(threshold_px)
    for index in range(1, len(sequence)):
        seen.take(index, tracker.away_px(tracker.step(sequence[index])))
        if seen.first is not None:
            return index
    raise seen.nothing_touched(rest_px)
