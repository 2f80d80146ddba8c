"""Area within an outline: the contact edge in the displacement field, and the circle of the previous work."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera
from casr.contact_area.edge import ContactEdge, fit_edge
from casr.contact_area.initial import InitialArea
from casr.contact_area.motion import PinMotion
from casr.flow.region import Region

MIN_EXPLAINED = 0.7  # noise alone reaches 0.57, presses of a real sensor 0.98
MAX_AREA_ERROR = 0.3


def edge_rule(motion: PinMotion, camera: Camera | None) -> InitialArea | str:
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


def circle_rule(motion: PinMotion, camera: Camera | None) -> InitialArea:
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
