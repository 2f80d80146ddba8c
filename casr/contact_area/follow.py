"""The front door of the contact front: which of its two models a press is told by."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera
from casr.contact_area.analytic_front import analytic_front
from casr.contact_area.front import ContactFront
from casr.contact_area.library_front import library_front
from casr.dome.library import Library
from casr.errors import PinsError

Array = NDArray[np.float64]

FEWEST_PINS, FEWEST_FRAMES = 7, 2
ELSEWHERE = 0.15
"Misfit of the library from which on the analytic field is tried, too."
FAR_BETTER = 0.5
"It is taken where its misfit is less than this share of the library's."


def contact_front(rest_px: Array, pins_px: Array, camera: Camera | None, library: Library) -> ContactFront:
    """The contact in T frames, by the library of finite-element domes or, where that explains nothing, analytically.

    Parameters
    ----------
    rest_px : (N, 2) pins at rest. pins_px : (T, N, 2) the same pins in contact; NaN where one is lost.
    camera : None leaves areas in px^2, and the size of the dome unknown.

    Raises
    ------
    PinsError : fewer than seven pins in some frame, or fewer than two frames.
    """
    rest_px, pins_px = np.asarray(rest_px, dtype=np.float64), np.asarray(pins_px, dtype=np.float64)
    fewest = int(np.isfinite(pins_px[..., 0]).sum(axis=1).min(initial=len(rest_px)))
    if fewest < FEWEST_PINS or len(pins_px) < FEWEST_FRAMES:
        raise PinsError(
            "contact front",
            wanted=f"{FEWEST_PINS} pins in every frame, and {FEWEST_FRAMES} frames",
            found=f"{fewest} pins, {len(pins_px)} frames",
            do="Leave out the frames without pins.",
        )
    front = library_front(rest_px, pins_px, camera, library)
    if front.misfit > ELSEWHERE:
        other = analytic_front(rest_px, pins_px, camera)
        if other.misfit < FAR_BETTER * front.misfit:
            front = replace(other, notes=(_said(other, front),))
    return front.with_note_on_size()


def _said(analytic: ContactFront, library: ContactFront) -> str:
    return (
        f"The pins do not move as on any dome of the library ({library.misfit:.0%} of the motion is left over), but as "
        f"over a skin that is flattened and stretched evenly ({analytic.misfit:.0%}): the edge is taken from that."
    )
