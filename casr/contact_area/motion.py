"""The pins at first contact: how they moved from the rest frame, and the array, which no contact is larger than."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.camera import Camera
from casr.errors import AreaError, PinsError
from casr.median import median
from casr.pins import pin_pitch_px
from casr.pins.lattice import NEIGHBOURS, at_border, nearest_pins


def array_area_px2(pins_px: NDArray[np.float64]) -> float:
    """Area of the convex hull of (N, 2) pins and half a pitch around it; pins that are NaN are left out."""
    seen, hull = _hull(pins_px)
    half_px = pin_pitch_px(seen) / 2
    return float(cv2.contourArea(hull) + cv2.arcLength(hull, True) * half_px + np.pi * half_px**2)


def _hull(pins_px: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
    """Pins that are seen, and the (K, 1, 2) corners of their convex hull."""
    seen = pins_px[np.isfinite(pins_px).all(axis=1)]
    return seen, np.asarray(cv2.convexHull(seen.astype(np.float32)), dtype=np.float32)


def check_area(area_px2: float, pins_px: NDArray[np.float64], what: str, camera: Camera | None) -> None:
    """AreaError where an area, px^2, is above that of the array of the (N, 2) pins, px, both without distortion."""
    if area_px2 <= cv2.contourArea(_hull(pins_px)[1]):  # most are: no need of the pitch
        return
    array_px2 = array_area_px2(pins_px)
    if not area_px2 > array_px2:
        return
    scale, unit = (1.0, "px²") if camera is None else (camera.mm2_per_px2, "mm²")
    raise AreaError(
        what, wanted=f"at most the area of the pin array, {scale * array_px2:.5g} {unit}",
        found=f"{scale * area_px2:.5g} {unit}",
        do="Choose the area rule edge, law ode, or a region that lies among the pins.",
    )  # fmt: skip


Array = NDArray[np.float64]

SHIFT_PX = 0.5
_NONE = np.zeros(0, dtype=bool)


@dataclass(frozen=True, eq=False)
class PinMotion:
    """Pins seen in both frames.

    ids : (n,) rows in the rest frame's pins. rest_px, contact_px : (n, 2) positions before and at contact.
    displacement_px : (n, 2) from one to the other, without the common shift. pitch_px : of the rest frame.
    notes : what was left out or taken off.
    """

    ids: NDArray[np.intp]
    rest_px: Array
    contact_px: Array
    displacement_px: Array
    pitch_px: float
    notes: tuple[str, ...]

    @cached_property
    def apart_px(self) -> Array:
        """(n, n) distances between pins at rest, px."""
        return np.asarray(np.hypot(*(self.rest_px[:, None] - self.rest_px[None]).transpose(2, 0, 1)))

    @cached_property
    def distance_px(self) -> Array:
        """(n,) how far each pin moved, px."""
        return np.asarray(np.hypot(*self.displacement_px.T))


def pin_motion(rest_px: ArrayLike, contact_px: ArrayLike) -> PinMotion:
    """Motion of the pins; those that are NaN in either frame are left out.

    A camera that shakes moves all pins alike, and pins at the border of the array are the last that a contact moves:
    the median of their displacement is taken off where it exceeds half a pixel.

    PinsError : arrays that do not fit, or fewer than seven pins in both frames.
    """
    rest, contact = (np.asarray(points, dtype=np.float64).reshape(-1, 2) for points in (rest_px, contact_px))
    seen = np.isfinite(rest).all(axis=1) & np.isfinite(contact).all(axis=1) if rest.shape == contact.shape else _NONE
    ids = np.flatnonzero(seen)
    if ids.size < 7:
        raise PinsError(
            "first contact", wanted="the same pins in the rest frame and in the first-contact frame, at least seven",
            found=f"{len(rest)} and {len(contact)} pins, {ids.size} in both",
            do="Check that the pins are found and tracked in these two frames.",
        )  # fmt: skip
    lost = len(rest) - ids.size
    notes: tuple[str, ...] = (f"{lost} of {len(rest)} pins are lost at first contact.",) if lost else ()
    rest, contact = rest[ids], contact[ids]
    pitch = pin_pitch_px(rest)
    displacement = contact - rest
    border = at_border(rest, nearest_pins(rest, NEIGHBOURS)[1])
    shift = median(displacement[border]) if border.any() else np.zeros(2)
    if np.hypot(*shift) > SHIFT_PX:
        displacement = displacement - shift
        notes += (f"A common shift of all pins by ({shift[0]:.2f}, {shift[1]:.2f}) px is taken off.",)
    return PinMotion(ids, rest, contact, displacement, pitch, notes)
