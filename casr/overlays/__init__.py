"""Pictures of one press: area against force, pins, front and skin, motion; all of a press at once."""

from __future__ import annotations

from typing import TYPE_CHECKING

from casr.overlays.area import area_picture, pins_picture
from casr.overlays.canvas import Picture
from casr.overlays.curves import area_curve, growth_curve
from casr.overlays.motion import edges_picture, flow_picture, spreading_picture
from casr.pins import PinSettings, PinTracker

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray

    from casr.frames import FrameSequence
    from casr.scoring import Score

__all__ = [
    "Picture", "area_picture", "flow_picture", "pin_ways", "pins_picture", "press_pictures", "spreading_picture",
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
