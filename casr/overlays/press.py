"""Pictures of one press: area against force, pins, front and skin, motion; all of a press at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from casr.flow.estimate import LOST_PERCENT, Followed, dense_flow
from casr.frames import FrameSequence
from casr.images import as_grey
from casr.overlays.curves import area_curve, growth_curve
from casr.overlays.frames import area_picture, edges_picture, flow_picture, pins_picture, spreading_picture
from casr.pins import PinSettings, PinTracker
from casr.scored import Score
from casr.svg import Picture

__all__ = [
    "area_picture", "flow_picture", "followed_picture", "pin_ways", "pins_picture", "press_pictures",
    "spreading_picture",
]  # fmt: skip


def press_pictures(sequence: FrameSequence, score: Score) -> tuple[Picture, ...]:
    """Pictures of ``score``, which comes from ``sequence``, of which three frames are decoded."""
    first, last = int(score.frames[0]), int(score.frames[-1])
    rest_px = score.rest.centroids_px
    initial = score.initial
    first_image = sequence[first]
    return (
        area_curve(score),
        edges_picture(sequence[last], score),
        growth_curve(score.frames, score.log_growth),
        pins_picture(sequence[score.rest_frame], rest_px, score.contact_px, initial),
        area_picture(first_image, rest_px, score.contact_px, initial, score.regions[0]),
        spreading_picture(
            first_image, score.pins_px[0], score.pins_px[-1], score.regions[0], f"frames {first} to {last}"
        ),
    )


def pin_ways(
    sequence: FrameSequence, frames: Sequence[int], pins: PinSettings | None = None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(N, 2) the pins of the first of ``frames``, there and in the last, px, followed frame by frame; NaN: lost."""
    tracker = PinTracker(pins)
    first_px = last_px = tracker.start(sequence[frames[0]]).centroids_px
    for index in frames[1:]:
        last_px = tracker.step(sequence[index])
    return first_px, last_px


def followed_picture(sequence: FrameSequence, followed: Followed) -> Picture:
    """A region that was followed: dense flow of the step in which it grows most, else the ways of the pins."""
    frames, regions, engine = followed.frames, followed.regions, followed.settings.engine
    if engine not in LOST_PERCENT:
        ways, span = pin_ways(sequence, frames, followed.settings.pins), f"frames {frames[0]} to {frames[-1]}"
        return spreading_picture(sequence[frames[0]], *ways, regions[0].polygon_px, span)
    place = max(range(len(followed.steps)), key=lambda i: abs(followed.steps[i].log_growth))
    before, after = frames[place : place + 2]
    method = dense_flow(followed.settings)
    method.start(as_grey(sequence[before]))
    image = as_grey(sequence[after])
    field = method.step(image, (0, 0, *reversed(image.shape)))
    return flow_picture(sequence[before], field, regions[place].polygon_px, f"frames {before} to {after}")
