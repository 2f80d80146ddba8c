"""Initial area by the rule asked for: a count of pins, one cell each (eqs 3 to 5), or the area within an outline."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera, undistorted
from casr.contact_area.array import check_area
from casr.contact_area.edge import ContactEdge, fit_edge
from casr.contact_area.motion import PinMotion, contact_cluster, pin_motion
from casr.errors import NoContactError, SettingError
from casr.flow.region import Region
from casr.pins import Pins, pin_pitch_px
from casr.pins.sites import Kind, lattice_kind


@dataclass(frozen=True, eq=False)
class InitialArea:
    """Area of the first contact.

    Parameters
    ----------
    area_mm2 : A_c0, mm^2; None without camera.
    area_px2 : the same in pixels of the undistorted image.
    rule : the rule that gave it.
    selected : (n,) rows of the rest frame's pins in the contact.
    polygon_px : (K, 2) outline of the contact in the first-contact frame. For hexagons it is their convex hull, whose
        area need not be A_c0.
    notes : what was left out, filled or fell back.
    relative_sd : standard deviation of the area for the noise of single pins, as a share of it; None where the rule
        does not tell.
    saturated : nearly all pins moved, so that the threshold shows the size of the array instead of the contact's.
    """

    area_mm2: float | None
    area_px2: float
    rule: str
    selected: NDArray[np.intp]
    polygon_px: NDArray[np.float64]
    notes: tuple[str, ...]
    relative_sd: float | None = None
    saturated: bool = False


def lattice_cell(pitch_px: float, kind: Kind, turn: float = 0.0) -> NDArray[np.float64]:
    """(6 or 4, 2) corners of the cell that each pin of a lattice has to itself: they tile it without gaps.

    A hexagon's apothem is half the pitch, so that its radius r_h is pitch / sqrt(3), as in eq. (3).

    Parameters
    ----------
    turn : of the lattice's rows against x, radians.
    """
    n = 4 if kind == "square" else 6
    angle = turn + 2 * np.pi / n * (np.arange(n) + 0.5)
    radius_px = pitch_px / (2 * np.cos(np.pi / n))
    return np.asarray(radius_px * np.column_stack([np.cos(angle), np.sin(angle)]))


def _cells_outline(centres_px: NDArray[np.float64], cell_px: NDArray[np.float64]) -> NDArray[np.float64]:
    """(K, 2) convex hull of the cells around (n, 2) centres, px."""
    return Region.from_points((centres_px[:, None] + cell_px).reshape(-1, 2)).polygon_px


SATURATED_SHARE = 0.9


def _hexagon_rule(motion: PinMotion, camera: Camera | None, threshold_px: float) -> InitialArea:
    """Pins that moved more than the threshold and those they enclose.

    Raises
    ------
    NoContactError : none moved.
    """
    inside, notes = contact_cluster(motion, threshold_px)
    moved = int((motion.distance_px > threshold_px).sum())
    if moved == 0:
        farthest = int(np.argmax(motion.distance_px))
        raise NoContactError(
            "first contact",
            wanted=f"pins that moved more than {threshold_px:g} px from the rest frame",
            found=f"at most {motion.distance_px[farthest]:.2f} px, by pin {motion.ids[farthest]}",
            do="Start at a higher force, or lower threshold_px (--threshold-px).",
        )
    saturated = moved >= SATURATED_SHARE * motion.ids.size
    if saturated:
        notes += (
            f"{moved} of {motion.ids.size} pins moved more than {threshold_px:g} px: the skin bulges everywhere, so "
            "this is the area of the array, not of the contact. Take an earlier first-contact frame, or rule 'edge'.",
        )
    return _hexagons(motion, camera, np.flatnonzero(inside), int(inside.sum()), "hexagon", notes, saturated)


def _paper_rule(motion: PinMotion, camera: Camera | None, threshold_px: float) -> InitialArea:
    """Algorithm 1 as it must be meant: whole-pixel centroids, each pin against itself in the other frame.

    Raises
    ------
    NoContactError : none moved.
    """
    moved_px = np.hypot(*(np.trunc(motion.contact_px) - np.trunc(motion.rest_px)).T)
    chosen = np.flatnonzero(moved_px > threshold_px)
    if not chosen.size:
        raise NoContactError(
            "first contact",
            wanted=f"pins that moved more than {threshold_px:g} px from the rest frame, in whole pixels",
            found=f"at most {moved_px.max():.2f} px, by pin {motion.ids[np.argmax(moved_px)]}",
            do="Start at a higher force, or lower threshold_px (--threshold-px).",
        )
    saturated = chosen.size >= SATURATED_SHARE * motion.ids.size
    return _hexagons(motion, camera, chosen, chosen.size, "paper", (), saturated)


def _printed_rule(motion: PinMotion, camera: Camera | None, threshold_px: float) -> InitialArea:
    """Algorithm 1 to the letter: whole-pixel centroids, every pin of the first frame against every one of the second.

    ``signpin.append`` runs for each pair further apart than the threshold, so a pin counts once for nearly every pin of
    the other frame and a motionless array of N pins has N (N - 1) hexagons.
    """
    first, second = np.trunc(motion.rest_px), np.trunc(motion.contact_px)
    apart = np.hypot(*(first[:, None] - second[None]).transpose(2, 0, 1)) > threshold_px
    count, chosen = int(apart.sum()), np.flatnonzero(apart.any(axis=1))
    if count == 0:
        farthest_px = float(np.hypot(*(first[:, None] - second[None]).transpose(2, 0, 1)).max())
        raise NoContactError(
            "first contact",
            wanted=f"pairs of pins of the two frames that are more than {threshold_px:g} px apart",
            found=f"at most {farthest_px:.0f} px",
            do="Lower threshold_px (--threshold-px).",
        )
    return _hexagons(motion, camera, chosen, count, AS_PRINTED, (), chosen.size >= SATURATED_SHARE * motion.ids.size)


def _hexagons(
    motion: PinMotion,
    camera: Camera | None,
    chosen: NDArray[np.intp],
    count: int,
    rule: str,
    notes: tuple[str, ...],
    saturated: bool,
) -> InitialArea:
    rest = motion.rest_px if camera is None else camera.undistorted_px(motion.rest_px)
    kind = lattice_kind(motion.rest_px)
    one_px2 = Region(lattice_cell(pin_pitch_px(rest), kind)).area_px2
    return InitialArea(
        area_mm2=None if camera is None else count * one_px2 * camera.mm2_per_px2,
        area_px2=count * one_px2,
        rule=rule,
        selected=motion.ids[chosen],
        polygon_px=_cells_outline(motion.contact_px[chosen], lattice_cell(motion.pitch_px, kind)),
        notes=motion.notes + notes,
        saturated=saturated,
    )


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
AS_PRINTED = "as-printed"
"A rule that no score can ask for: its area is that of thousands of hexagons, which no sensor has."


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
        return _paper_rule(motion, camera, threshold_px)
    if rule == AS_PRINTED:
        return _printed_rule(motion, camera, threshold_px)
    if rule == "edge":
        found = _edge_rule(motion, camera)
        if isinstance(found, InitialArea):
            return found
        motion = replace(motion, notes=(*motion.notes, f"No contact edge: {found}; hexagons instead."))
    return _hexagon_rule(motion, camera, threshold_px)
