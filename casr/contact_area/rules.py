"""Initial area by the rule asked for: Algorithm 1, or the area within an outline."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera, undistorted
from casr.contact_area.algorithm_1 import AS_PRINTED, hexagon_rule, paper_rule, printed_rule
from casr.contact_area.array import check_area
from casr.contact_area.edge import ContactEdge, fit_edge
from casr.contact_area.initial_area import InitialArea
from casr.contact_area.motion import PinMotion, pin_motion
from casr.errors import SettingError
from casr.flow.region import Region
from casr.pins import Pins

MIN_EXPLAINED = 0.7  # noise alone reaches 0.57, presses of a real sensor 0.98
MAX_AREA_ERROR = 0.3


def _edge_rule(motion: PinMotion, camera: Camera | None) -> InitialArea | str:
    """Ellipse at the contact edge as it lies in the first-contact frame; where the fit is not sound, why."""
    if not motion.displacement_px.any():
        return "no pin moved"
    edge = fit_edge(motion.rest_px, motion.displacement_px, motion.pitch_px)
    if (doubt := _doubt(edge)) is not None:
        return doubt
    shift = np.median(motion.contact_px - motion.rest_px - motion.displacement_px, axis=0) + edge.shift_px
    # inside the edge the rest frame is stretched about the centre, so this is the same piece of skin
    grow = 1 + edge.stretch
    x_px, y_px = (edge.centre_px + shift).tolist()
    region = Region.ellipse(x_px, y_px, edge.a_px * grow, edge.b_px * grow, turn_deg=edge.turn_deg)
    inside = region.contains(motion.contact_px)
    if not 3 <= inside.sum() <= motion.ids.size / 2:
        return f"{int(inside.sum())} of {motion.ids.size} pins would lie inside"
    return replace(_within(region, motion, camera, "edge", inside), relative_sd=edge.area_error)


def _doubt(edge: ContactEdge) -> str | None:
    if edge.explained < MIN_EXPLAINED:
        return f"only {100 * max(edge.explained, 0):.0f} % of the motion has the form of a contact"
    if not edge.area_error <= MAX_AREA_ERROR:
        return f"its area would be good to {100 * edge.area_error:.0f} % only"
    if edge.stretch <= 0:
        return "pins move towards a centre, not away from it"
    return None


def _circle_rule(motion: PinMotion, camera: Camera | None) -> InitialArea:
    """Circle around the pin nearest the middle of the array through the pin farthest from it."""
    rest = motion.rest_px
    centre = rest[np.argmin(((rest - rest.mean(axis=0)) ** 2).sum(axis=1))]
    region = Region.circle(float(centre[0]), float(centre[1]), float(np.hypot(*(rest - centre).T).max()))
    notes = ("The circle encloses all pins: it does not depend on the contact.",)
    return _within(region, motion, camera, "circle", np.ones(motion.ids.size, dtype=bool), notes)


def _within(
    region: Region,
    motion: PinMotion,
    camera: Camera | None,
    rule: str,
    inside: NDArray[np.bool_],
    notes: tuple[str, ...] = (),
) -> InitialArea:
    flat = region if camera is None else Region(camera.undistorted_px(region.polygon_px))
    return InitialArea(
        area_mm2=None if camera is None else flat.area_px2 * camera.mm2_per_px2,
        area_px2=flat.area_px2,
        rule=rule,
        selected=motion.ids[inside],
        polygon_px=region.polygon_px,
        notes=motion.notes + notes,
    )


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
        frame; ``hexagon`` with a note where the fit is not sound. ``hexagon``: one hexagon, of a square lattice one
        square, for each pin that moved more than ``threshold_px`` and each pin those enclose; pitch of the rest frame
        (Algorithm 1, pairs one to one).
        ``circle``: through the pin farthest from the central one, of all pins (previous work; the same whatever is
        touched). ``paper``: Algorithm 1 as it must be meant, one hexagon for each pin whose centroid, in whole pixels,
        moved more than ``threshold_px``. ``as-printed``: to the letter, one for each pair of pins of the two frames
        that far apart.
    threshold_px : of ``hexagon``, ``paper`` and ``as-printed``.

    Raises
    ------
    NoContactError : no pin moved enough.
    AreaError : the area is above that of the pin array; ``circle`` is not checked, it measures the array.
    PinsError : too few pins in both frames.
    SettingError : unknown rule, or a threshold not above 0.
    """
    if rule not in (*RULES, AS_PRINTED):
        wanted = " or ".join((*RULES, AS_PRINTED))
        raise SettingError("rule", wanted=wanted, found=repr(rule), do="Choose one of these.")
    if not 0 < threshold_px < np.inf:
        raise SettingError(
            "threshold_px", wanted="a distance above 0 px", found=repr(threshold_px), do="The paper uses 2."
        )
    motion = pin_motion(rest.centroids_px, contact_px)
    if rule == "circle":
        return _circle_rule(motion, camera)  # the array itself, and a trifle more than its hull
    found = _by_rule(motion, camera, rule, threshold_px)
    pins_px = motion.contact_px if found.rule == "edge" else motion.rest_px  # hexagons are those of the rest frame
    check_area(found.area_px2, undistorted(pins_px, camera), f"initial area by rule {found.rule}", camera)
    return found


def _by_rule(motion: PinMotion, camera: Camera | None, rule: str, threshold_px: float) -> InitialArea:
    if rule == "paper":
        return paper_rule(motion, camera, threshold_px)
    if rule == AS_PRINTED:
        return printed_rule(motion, camera, threshold_px)
    if rule == "edge":
        found = _edge_rule(motion, camera)
        if isinstance(found, InitialArea):
            return found
        motion = replace(motion, notes=(*motion.notes, f"No contact edge: {found}; hexagons instead."))
    return hexagon_rule(motion, camera, threshold_px)
