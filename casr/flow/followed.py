"""A region of skin followed from one frame of a sequence to another, step by step."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from casr.errors import FramesError, PinsError, said_of
from casr.flow.estimate import FlowTracker
from casr.flow.pin_engine import need_pins_inside
from casr.flow.region import Region
from casr.flow.step import MOST_BAD_FRAMES, FlowSettings, FlowStep, notes_by_frame
from casr.frames import FrameSequence
from casr.pins import detect_pins, pins_in_doubt


@dataclass(frozen=True, eq=False)
class Followed:
    """A region in T frames.

    frames : (T,) indices of those that were not left out. steps : (T-1,) from each to the next. regions : (T,) in each.
    """

    settings: FlowSettings
    frames: tuple[int, ...]
    steps: tuple[FlowStep, ...]
    regions: tuple[Region, ...]

    def rows(self) -> list[dict[str, Any]]:
        """Facts of each step, JSON-ready; ``sum`` is the logarithm of growth since the first frame."""
        sums = itertools.accumulate(step.log_growth for step in self.steps)
        return [
            {
                "from": before, "to": after, "divergence": float(step.divergence),
                "log_growth": float(step.log_growth), "sum": float(total), "used": int(step.n),
            }
            for (before, after), step, total in zip(itertools.pairwise(self.frames), self.steps, sums, strict=True)
        ]  # fmt: skip


def follow_region(
    sequence: FrameSequence,
    settings: FlowSettings,
    ends: tuple[int, int] | None = None,
    region: Region | None = None,
    say: Callable[[str], object] = str,
) -> Followed:
    """Follow a region; a frame in which the pins cannot be told is left out.

    ends : first and last frame, which may run backwards; None: all. region : in the first frame; None: a circle about
    the middle of the pins, half as wide as they reach. say : hears what a reader should know, as soon as it is found.

    Raises
    ------
    FramesError : a frame that is not there. SettingError : a region outside the image, or with fewer than three pins.
    PinsError : too few pins, or three bad frames in a row.
    """
    first, last = ends or (0, len(sequence) - 1)
    if max(first, last) >= len(sequence):
        raise FramesError(
            sequence.name, wanted=f"frames from 0 to {len(sequence) - 1}", found=f"{first},{last}",
            do="Frames are counted from 0.",
        )  # fmt: skip
    region = _region(sequence[first], region, settings, say)
    tracker = FlowTracker(settings)
    tracker.start(sequence[first], region)
    forward = 1 if last > first else -1
    good, steps, n_bad = [first], [], 0
    for after in range(first + forward, last + forward, forward):
        image = sequence[after]
        with said_of(f"{sequence.name}, frame {after}"):
            try:
                steps.append(tracker.step(image))
            except PinsError as trouble:
                n_bad += 1
                if n_bad > MOST_BAD_FRAMES or (after == last and not steps):
                    raise
                say(f"frame {after} is left out: {trouble}")
                continue
        n_bad = 0
        good.append(after)
    for note in notes_by_frame(good[1:], steps):
        say(note)
    return Followed(settings, tuple(good), tuple(steps), (region, *(step.region for step in steps)))


def _region(image: Any, asked: Region | None, settings: FlowSettings, say: Callable[[str], object]) -> Region:
    if asked is not None and settings.engine != "pin-affine":
        return asked
    pins_px = detect_pins(image, settings.pins).centroids_px
    for doubt in pins_in_doubt(pins_px, settings.pins.expect_pins):
        say(doubt)
    if asked is not None:
        need_pins_inside(asked, pins_px)
        return asked
    centre = (pins_px.min(axis=0) + pins_px.max(axis=0)) / 2
    return Region.circle(float(centre[0]), float(centre[1]), float(np.hypot(*(pins_px - centre).T).max()) / 2)
