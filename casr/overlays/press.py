"""All pictures of one scored press."""

from __future__ import annotations

from typing import TYPE_CHECKING

from casr.overlays.area import area_picture, pins_picture
from casr.overlays.canvas import Picture, style
from casr.overlays.curves import area_curve, growth_curve, readable
from casr.overlays.motion import region_picture, spreading_picture
from casr.pins import PinTracker

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from casr.frames import FrameSequence
    from casr.score import Score


def press_pictures(sequence: FrameSequence, score: Score) -> tuple[Picture, ...]:
    """Pictures of ``score``, which comes from ``sequence``; the curve over force only where there is a force."""
    first, last = int(score.frames[0]), int(score.frames[-1])
    rest_px = score.rest.centroids_px
    initial = score.initial
    area = f"{score.area[0]:.4g} {readable(score.area_unit)}"
    with style():
        made = [
            pins_picture(sequence[score.rest_frame], rest_px, score.contact_px, initial),
            area_picture(sequence[first], rest_px, score.contact_px, initial, area),
            region_picture(sequence[last], rest_px, score.regions, score.frames, score.force_n),
            spreading_picture(
                sequence[first], *_ends(sequence, score.frames), score.regions[0], f"frames {first} to {last}"
            ),
            growth_curve(score.frames, score.log_growth),
        ]
        if score.force_n is not None:
            made.insert(0, area_curve(score.force_n, score.area, score.area_unit, score.rate))
    return tuple(made)


def _ends(sequence: FrameSequence, frames: NDArray[np.int_]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(N, 2) the pins of the first frame there and in the last one, px, NaN where lost."""
    tracker = PinTracker()
    first_px = last_px = tracker.start(sequence[int(frames[0])]).centroids_px
    for index in frames[1:].tolist():
        last_px = tracker.step(sequence[index])
    return first_px, last_px
