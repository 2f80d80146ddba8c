"""The area of the first contact, A_c0, by the rule asked for: within an outline, or as a count of hexagons.

Algorithm 1 of the paper (IV.A) counts pins that moved, one hexagon (eq. 3) each. Its listing, and who does it here:

1, 2  pins of the frame at rest and of the first contact   ``casr.pins.detect``, and ``casr.pins.track`` pairs them
3     how far each pin moved                               ``casr.contact_area.motion.pin_motion``
4     keep those that moved more than the threshold        ``paper_rule``, ``hexagon_rule``; to the letter,
                                                           ``printed_rule``
5     one hexagon of radius r_h for each, eq. (3)          ``lattice_cell``, ``_hexagons``
6     pixels to millimetres, eqs (4) and (5)               ``casr.camera.Camera.mm2_per_px2``
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera, undistorted
from casr.contact_area.edge import ContactEdge, fit_edge
from casr.contact_area.motion import PinMotion, check_area, pin_motion
from casr.errors import NoContactError, SettingError
from casr.flow.region import Region
from casr.pins import Pins, pin_pitch_px
from casr.pins.lattice import Kind, lattice_kind


@dataclass(frozen=True, eq=False)
class InitialArea:
    """Area of the first contact.

    area_mm2 : A_c0, mm^2; None without camera. area_px2 : the same in pixels of the undistorted image.
    rule : the rule that gave it. selected : (n,) rows of the rest frame's pins in the contact.
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

    def __repr__(self) -> str:
        area = f"{self.area_px2:.4g} px2" if self.area_mm2 is None else f"{self.area_mm2:.4g} mm2"
        notes = f", {len(self.notes)} notes" if self.notes else ""
        return f"InitialArea({area} by rule {self.rule}, {self.selected.size} pins{notes})"


@dataclass(frozen=True, eq=False)
class FirstContact:
    """How the pins moved from rest to the first contact, and its edge: found once, whatever rules ask for it."""

    motion: PinMotion

    @classmethod
    def of(cls, rest_px: NDArray[np.float64], contact_px: NDArray[np.float64]) -> FirstContact:
        """Of (N, 2) places of pins, NaN where one is lost. PinsError as ``pin_motion``."""
        return cls(pin_motion(rest_px, contact_px))

    @cached_property
    def edge(self) -> ContactEdge | None:
        """None where no pin moved."""
        return fit_edge(self.motion) if self.motion.displacement_px.any() else None


AS_PRINTED = "as-printed"
"""A rule that no score can ask for: its area is that of thousands of hexagons, which no sensor has."""
MIN_EXPLAINED = 0.7  # noise alone reaches 0.57, presses of a real sensor 0.98
MAX_AREA_ERROR = 0.3
SATURATED_SHARE = 0.9
GROUP_PITCHES = 2.5  # across the pin in the middle of the contact, which stays
_LOWER = "lower threshold_px (--threshold-px)."


def initial_area(
    rest: Pins,
    contact_px: NDArray[np.float64],
    *,
    camera: Camera | None = None,
    rule: str = "edge",
    threshold_px: float = 2.0,
) -> InitialArea:
    """Area of the first contact from the pins before it and at it.

    rest : pins of the rest frame. contact_px : (N, 2) where the same pins are in the first-contact frame; NaN where one
    is lost. camera : for mm and distortion; without it areas are in px^2 only.
    rule : ``edge``: ellipse at the fold of the displacement field (``fit_edge``), as it lies in the first-contact
    frame; ``hexagon`` with a note where the fit is not sound. ``hexagon``: one hexagon, of a square lattice one
    square, for each pin that moved more than ``threshold_px`` and each pin those enclose; pitch of the rest frame
    (Algorithm 1, pairs one to one). ``circle``: through the pin farthest from the central one, of all pins (previous
    work; the same whatever is touched). ``paper``: Algorithm 1 as it must be meant, one hexagon for each pin whose
    centroid, in whole pixels, moved more than ``threshold_px``. ``as-printed``: to the letter, one for each pair of
    pins of the two frames that far apart.
    threshold_px : of ``hexagon``, ``paper`` and ``as-printed``.

    NoContactError : no pin moved enough. AreaError : the area is above that of the pin array; ``circle`` is not
    checked, it measures the array. PinsError : too few pins in both frames. SettingError : unknown rule, or a threshold
    not above 0.
    """
    return area_of(FirstContact.of(rest.centroids_px, contact_px), camera, rule, threshold_px)


def area_of(contact: FirstContact, camera: Camera | None, rule: str, threshold_px: float) -> InitialArea:
    """As ``initial_area``, of a contact whose edge several rules may ask for."""
    if rule not in _RULES:
        raise SettingError("rule", wanted=" or ".join(_RULES), found=repr(rule), do="Choose one of these.")
    if not 0 < threshold_px < np.inf:
        wanted, do = "a distance above 0 px", "The paper uses 2."
        raise SettingError("threshold_px", wanted=wanted, found=repr(threshold_px), do=do)
    motion, found = contact.motion, _RULES[rule](contact, camera, threshold_px)
    if rule != "circle":  # which is the array itself, and a trifle more than its hull
        pins_px = motion.contact_px if found.rule == "edge" else motion.rest_px  # hexagons are those of the rest frame
        check_area(found.area_px2, undistorted(pins_px, camera), f"initial area by rule {found.rule}", camera)
    return found


def edge_rule(contact: FirstContact, camera: Camera | None, threshold_px: float) -> InitialArea:
    """Ellipse at the contact edge as it lies in the first-contact frame; where the fit is not sound, hexagons.

    threshold_px : of the hexagons, px. NoContactError : no pin moved that far.
    """
    found = _within_edge(contact, camera)
    if isinstance(found, InitialArea):
        return found
    motion = contact.motion
    said = (*motion.notes, f"No contact edge: {found}; hexagons instead.")
    return hexagon_rule(FirstContact(replace(motion, notes=said)), camera, threshold_px)


def _within_edge(contact: FirstContact, camera: Camera | None) -> InitialArea | str:
    """What lies within the edge; where the fit is not sound, why."""
    motion, edge = contact.motion, contact.edge
    if edge is None:
        return "no pin moved"
    if (doubt := _doubt(edge)) is not None:
        return doubt
    region = edge.at_contact(motion)
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


def circle_rule(contact: FirstContact, camera: Camera | None, threshold_px: float) -> InitialArea:
    """Circle around the pin nearest the middle of the array through the pin farthest from it: the way before the paper.
    ``threshold_px`` (px) has no part in it."""
    motion, rest = contact.motion, contact.motion.rest_px
    centre = rest[np.argmin(((rest - rest.mean(axis=0)) ** 2).sum(axis=1))]
    region = Region.circle(float(centre[0]), float(centre[1]), float(np.hypot(*(rest - centre).T).max()))
    found = _within(region, motion, camera, "circle", np.ones(motion.ids.size, dtype=bool))
    return replace(found, notes=(*found.notes, "The circle encloses all pins: it does not depend on the contact."))


def _within(
    region: Region, motion: PinMotion, camera: Camera | None, rule: str, inside: NDArray[np.bool_]
) -> InitialArea:
    area_px2 = Region(undistorted(region.polygon_px, camera)).area_px2
    area_mm2 = None if camera is None else area_px2 * camera.mm2_per_px2
    return InitialArea(area_mm2, area_px2, rule, motion.ids[inside], region.polygon_px, motion.notes)


def hexagon_rule(contact: FirstContact, camera: Camera | None, threshold_px: float) -> InitialArea:
    """Pins that moved more than ``threshold_px`` and those they enclose, a hexagon each (paper, eq. 3).

    NoContactError : no pin moved more than that, px.
    """
    motion = contact.motion
    moved = motion.distance_px > threshold_px
    if not moved.any():
        raise _none_moved(motion, motion.distance_px, f"{threshold_px:g} px from the rest frame")
    inside, notes = _contact_cluster(motion, moved)
    found = _hexagons(motion, camera, inside, int(inside.sum()), "hexagon", _most(moved))
    if found.saturated:
        notes += (
            f"{moved.sum()} of {moved.size} pins moved more than {threshold_px:g} px: the skin bulges everywhere, so "
            "this is the area of the array, not of the contact. Take an earlier first-contact frame, or rule 'edge'.",
        )
    return replace(found, notes=found.notes + notes)


def paper_rule(contact: FirstContact, camera: Camera | None, threshold_px: float) -> InitialArea:
    """Algorithm 1 as it must be meant: whole-pixel centroids, each pin against itself in the other frame.
    NoContactError : none moved more than ``threshold_px``."""
    motion = contact.motion
    moved_px = np.hypot(*(np.trunc(motion.contact_px) - np.trunc(motion.rest_px)).T)
    moved = moved_px > threshold_px
    if not moved.any():
        raise _none_moved(motion, moved_px, f"{threshold_px:g} px from the rest frame, in whole pixels")
    return _hexagons(motion, camera, moved, int(moved.sum()), "paper", _most(moved))


def printed_rule(contact: FirstContact, camera: Camera | None, threshold_px: float) -> InitialArea:
    """Algorithm 1 to the letter: whole-pixel centroids, every pin of the first frame against every one of the second.

    ``signpin.append`` runs for each pair further apart than the threshold, so a pin counts once for nearly every pin of
    the other frame and a motionless array of N pins has N (N - 1) hexagons.
    NoContactError : no two pins are further apart than the threshold.
    """
    motion = contact.motion
    first, second = np.trunc(motion.rest_px), np.trunc(motion.contact_px)
    apart_px = np.hypot(*(first[:, None] - second[None]).transpose(2, 0, 1))
    apart = apart_px > threshold_px
    if not apart.any():
        wanted = f"pairs of pins of the two frames that are more than {threshold_px:g} px apart"
        found = f"at most {apart_px.max():.0f} px"
        raise NoContactError("first contact", wanted=wanted, found=found, do=_LOWER.capitalize())
    chosen = apart.any(axis=1)
    return _hexagons(motion, camera, chosen, int(apart.sum()), AS_PRINTED, _most(chosen))


_RULES: dict[str, Callable[[FirstContact, Camera | None, float], InitialArea]] = {
    "edge": edge_rule, "hexagon": hexagon_rule, "circle": circle_rule, "paper": paper_rule,
    AS_PRINTED: printed_rule,
}  # fmt: skip
RULES = tuple(rule for rule in _RULES if rule != AS_PRINTED)


def _none_moved(motion: PinMotion, moved_px: NDArray[np.float64], than: str) -> NoContactError:
    farthest = int(np.argmax(moved_px))
    return NoContactError(
        "first contact", wanted=f"pins that moved more than {than}",
        found=f"at most {moved_px[farthest]:.2f} px, by pin {motion.ids[farthest]}",
        do=f"Start at a higher force, or {_LOWER}",
    )  # fmt: skip


def _most(moved: NDArray[np.bool_]) -> bool:
    return bool(moved.sum() >= SATURATED_SHARE * moved.size)


def lattice_cell(pitch_px: float, kind: Kind, turn: float = 0.0) -> NDArray[np.float64]:
    """(6 or 4, 2) corners of the cell that each pin of a lattice has to itself: they tile it without gaps.

    A hexagon's apothem is half the pitch, so that its radius r_h is pitch / sqrt(3), as in eq. (3).

    turn : of the lattice's rows against x, radians.
    """
    n = 4 if kind == "square" else 6
    angle = turn + 2 * np.pi / n * (np.arange(n) + 0.5)
    radius_px = pitch_px / (2 * np.cos(np.pi / n))
    return np.asarray(radius_px * np.column_stack([np.cos(angle), np.sin(angle)]))


def _hexagons(
    motion: PinMotion, camera: Camera | None, chosen: NDArray[np.bool_], count: int, rule: str, saturated: bool
) -> InitialArea:
    kind = lattice_kind(motion.rest_px)
    one_px2 = Region(lattice_cell(pin_pitch_px(undistorted(motion.rest_px, camera)), kind)).area_px2
    cells_px = motion.contact_px[chosen][:, None] + lattice_cell(motion.pitch_px, kind)
    return InitialArea(
        area_mm2=None if camera is None else count * one_px2 * camera.mm2_per_px2, area_px2=count * one_px2, rule=rule,
        selected=motion.ids[chosen], polygon_px=Region.from_points(cells_px.reshape(-1, 2)).polygon_px,
        notes=motion.notes, saturated=saturated,
    )  # fmt: skip


def _contact_cluster(motion: PinMotion, moved: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], tuple[str, ...]]:
    """(n,) whether each pin is in contact: the largest group of moved pins close together, and the pins they enclose.

    The pin in the middle of the contact cannot move, so pins within the convex hull of the group count: contacts of
    convex bodies are convex.
    """
    cluster = _largest_group(moved, motion.apart_px < GROUP_PITCHES * motion.pitch_px)
    dropped = int(moved.sum() - cluster.sum())
    notes = (f"Pins that moved apart from the contact are left out: {dropped}.",) if dropped else ()
    if cluster.sum() >= 3:
        cluster = cluster | Region.from_points(motion.rest_px[cluster]).contains(motion.rest_px)
    return cluster, notes


def _largest_group(members: NDArray[np.bool_], near: NDArray[np.bool_]) -> NDArray[np.bool_]:
    left, best = members.copy(), np.zeros_like(members)
    while left.any():
        group = np.zeros_like(members)
        group[np.argmax(left)] = True
        while (grown := group | (near[group].any(axis=0) & members)).sum() > group.sum():
            group = grown
        left &= ~group
        if group.sum() > best.sum():
            best = group
    return best
