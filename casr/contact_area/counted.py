"""Area as a count of pins, one hexagon each: Algorithm 1 as it is meant, and to the letter."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera
from casr.contact_area.hexagons import hexagon_area, hexagon_radius_px, hexagons_outline
from casr.contact_area.initial import InitialArea
from casr.contact_area.motion import PinMotion, contact_cluster
from casr.errors import NoContactError
from casr.pins import pin_pitch_px

SATURATED_SHARE = 0.9


def hexagon_rule(motion: PinMotion, camera: Camera | None, threshold_px: float) -> InitialArea:
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


def paper_rule(motion: PinMotion, camera: Camera | None, threshold_px: float) -> InitialArea:
    """Algorithm 1 as printed: whole-pixel centroids, every pin of the first frame against every one of the second.

    ``signpin.append`` runs for each pair further apart than the threshold, so a pin counts once for nearly every pin of
    the other frame and a motionless array of N pins has N (N - 1) hexagons.
    """
    first, second = np.trunc(motion.rest_px), np.trunc(motion.contact_px)
    apart = np.hypot(*(first[:, None] - second[None]).transpose(2, 0, 1)) > threshold_px
    count, chosen = int(apart.sum()), np.flatnonzero(apart.any(axis=1))
    own = int(np.diagonal(apart).sum())
    notes = (
        f"As printed, {count} pairs of {motion.ids.size} pins are more than {threshold_px:g} px apart and each adds a "
        f"hexagon; {own} pins are that far from their own place.",
    )
    return _hexagons(motion, camera, chosen, count, "paper", notes, chosen.size >= SATURATED_SHARE * motion.ids.size)


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
    one_px2, one_mm2 = hexagon_area(hexagon_radius_px(pin_pitch_px(rest)), camera)
    return InitialArea(
        area_mm2=None if one_mm2 is None else count * one_mm2,
        area_px2=count * one_px2,
        rule=rule,
        selected=motion.ids[chosen],
        polygon_px=hexagons_outline(motion.contact_px[chosen], hexagon_radius_px(motion.pitch_px)),
        notes=motion.notes + notes,
        saturated=saturated,
    )
