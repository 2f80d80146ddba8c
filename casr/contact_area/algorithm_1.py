"""Algorithm 1 of the paper: initial contact area A_c0 as a count of pins that moved, one hexagon (eq. 3) each.

The listing, and who does it here:

1, 2  pins of the frame at rest and of the first contact   ``casr.pins.detect``, and ``casr.pins.track`` pairs them
3     how far each pin moved                               ``casr.contact_area.motion.pin_motion``
4     keep those that moved more than the threshold        ``paper_rule``, ``hexagon_rule``; to the letter,
                                                           ``printed_rule``
5     one hexagon of radius r_h for each, eq. (3)          ``lattice_cell``, ``_hexagons``
6     pixels to millimetres, eqs (4) and (5)               ``casr.camera.Camera.mm2_per_px2``
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera
from casr.contact_area.initial_area import InitialArea
from casr.contact_area.motion import PinMotion
from casr.errors import NoContactError
from casr.flow.region import Region
from casr.pins import pin_pitch_px
from casr.pins.sites import Kind, lattice_kind

AS_PRINTED = "as-printed"
"""A rule that no score can ask for: its area is that of thousands of hexagons, which no sensor has."""
SATURATED_SHARE = 0.9
GROUP_PITCHES = 2.5  # across the pin in the middle of the contact, which stays


def paper_rule(motion: PinMotion, camera: Camera | None, threshold_px: float) -> InitialArea:
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


def hexagon_rule(motion: PinMotion, camera: Camera | None, threshold_px: float) -> InitialArea:
    """Pins that moved more than the threshold and those they enclose.

    Raises
    ------
    NoContactError : none moved.
    """
    inside, notes = _contact_cluster(motion, threshold_px)
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


def printed_rule(motion: PinMotion, camera: Camera | None, threshold_px: float) -> InitialArea:
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


def _cells_outline(centres_px: NDArray[np.float64], cell_px: NDArray[np.float64]) -> NDArray[np.float64]:
    """(K, 2) convex hull of the cells around (n, 2) centres, px."""
    return Region.from_points((centres_px[:, None] + cell_px).reshape(-1, 2)).polygon_px


def _contact_cluster(motion: PinMotion, threshold_px: float) -> tuple[NDArray[np.bool_], tuple[str, ...]]:
    """(n,) whether each pin is in contact: the largest group of moved pins close together, and the pins they enclose.

    The pin in the middle of the contact cannot move, so pins within the convex hull of the group count: contacts of
    convex bodies are convex.
    """
    moved = motion.distance_px > threshold_px
    cluster = _largest_group(moved, motion.apart_px < GROUP_PITCHES * motion.pitch_px)
    notes: tuple[str, ...] = ()
    if (dropped := int(moved.sum() - cluster.sum())) > 0:
        notes += (f"Pins that moved apart from the contact are left out: {dropped}.",)
    if cluster.sum() >= 3:
        hull = Region.from_points(motion.rest_px[cluster])
        cluster = cluster | hull.contains(motion.rest_px)
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
