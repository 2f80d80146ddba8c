"""The loading phase of a press without a force log, as its pins show it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from casr.errors import FramesError, NoContactError
from casr.frames import FrameSequence, LoadingPhase
from casr.pins import PinSettings, PinTracker, detect_pins
from casr.pins.sites import on_lattice

TOUCHED_PINS = 3  # one pin may be a reflection, two on a line span no contact


def first_touch(sequence: FrameSequence, threshold_px: float, pins: PinSettings | None = None) -> int:
    """The first frame in which three pins have moved more than ``threshold_px`` from where they are in frame 0.

    Raises
    ------
    NoContactError : there is none. PinsError : too few pins in frame 0.
    """
    most, farthest_px = 0, 0.0
    for index, moved_px in _moved(sequence, pins):
        n_moved = int(np.sum(moved_px > threshold_px))
        if n_moved >= TOUCHED_PINS:
            return index
        most, farthest_px = max(most, n_moved), max(farthest_px, float(moved_px.max(initial=0.0)))
    rest_px = detect_pins(sequence[0], pins).centroids_px
    do = "Begin with a frame at rest, lower threshold_px (--threshold-px), or give the region."
    if not on_lattice(rest_px):
        do = (
            "Frame 0 shows no lattice of pins: only sensors with pins can be scored. If it has some, help to find them "
        )
        do += "(--pitch, --contrast, --min-area, --dark-pins)."
    raise NoContactError(
        "pins",
        wanted=f"{TOUCHED_PINS} pins that move more than {threshold_px:g} px from frame 0 in one frame",
        found=f"at most {most} of {len(rest_px)}; the farthest that any moves is {farthest_px:.2f} px",
        do=do,
    )


def seen_loading(sequence: FrameSequence, first: int, pins: PinSettings | None = None) -> LoadingPhase:
    """From frame ``first`` to the one in which the pins are farthest from frame 0, the rest frame, on average.

    Raises
    ------
    FramesError : fewer than two frames. PinsError : too few pins in frame 0.
    """
    away_px = {index: float(moved_px.mean()) for index, moved_px in _moved(sequence, pins) if moved_px.size}
    last = max((index for index in away_px if index >= first), key=away_px.__getitem__, default=first)
    if last == first:
        raise FramesError(
            "loading phase",
            wanted="at least two frames in contact while the pins move away from rest",
            found=f"one, frame {first} of {len(sequence)}",
            do="Record on into the press.",
        )
    note = f"no force log: loading is taken from frame {first} to {last}, the pins' farthest from rest on average"
    return LoadingPhase(0, np.arange(first, last + 1), (f"{note}; there is no spread rate",))


def _moved(sequence: FrameSequence, pins: PinSettings | None) -> Iterator[tuple[int, NDArray[np.float64]]]:
    """Every later frame, and how far each pin seen in it is from its place in frame 0, knocks taken off, px."""
    tracker = PinTracker(pins)
    rest_px = tracker.start(sequence[0]).centroids_px
    for index in range(1, len(sequence)):
        moved_px = np.hypot(*(tracker.step(sequence[index]) - tracker.knock_px - rest_px).T)
        yield index, moved_px[np.isfinite(moved_px)]
