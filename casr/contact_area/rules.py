"""Initial area by the rule asked for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera
from casr.contact_area.counted import hexagon_rule, paper_rule
from casr.contact_area.initial import InitialArea
from casr.contact_area.motion import pin_motion
from casr.contact_area.outlined import circle_rule, edge_rule
from casr.errors import SettingError
from casr.pins import Pins

RULES = ("edge", "hexagon", "circle", "paper")


def initial_area(
    rest: Pins,
    contact_px: NDArray[np.float64],
    *,
    camera: Camera | None = None,
    rule: str = "edge",
    threshold_px: float = 2.0,
) -> InitialArea:
    """Area of the first contact from the pins before it and at it.

    Parameters
    ----------
    rest : pins of the rest frame.
    contact_px : (N, 2) where the same pins are in the first-contact frame; NaN where one is lost.
    camera : for mm and distortion; without it areas are in px^2 only.
    rule : ``edge``: ellipse at the fold of the displacement field (``fit_edge``), as it lies in the first-contact
        frame; ``hexagon`` with a note where the fit is not sound. ``hexagon``: one hexagon for each pin that moved more
        than ``threshold_px`` and each pin those enclose; pitch of the rest frame (Algorithm 1, pairs one to one).
        ``circle``: through the pin farthest from the central one, of all pins (previous work; the same whatever is
        touched). ``paper``: Algorithm 1 to the letter, whole-pixel centroids and all pairs of pins.
    threshold_px : of ``hexagon`` and ``paper``.

    Raises
    ------
    NoContactError : no pin moved enough.
    PinsError : too few pins in both frames.
    SettingError : unknown rule, or a threshold not above 0.
    """
    if rule not in RULES:
        raise SettingError("rule", wanted=" or ".join(RULES), found=repr(rule), do="Choose one of these.")
    if not 0 < threshold_px < np.inf:
        raise SettingError(
            "threshold_px", wanted="a distance above 0 px", found=repr(threshold_px), do="The paper uses 2."
        )
    motion = pin_motion(rest.centroids_px, contact_px)
    if rule == "circle":
        return circle_rule(motion, camera)
    if rule == "paper":
        return paper_rule(motion, camera, threshold_px)
    if rule == "edge":
        found = edge_rule(motion, camera)
        if isinstance(found, InitialArea):
            return found
        motion = replace(motion, notes=(*motion.notes, f"No contact edge: {found}; hexagons instead."))
    return hexagon_rule(motion, camera, threshold_px)
