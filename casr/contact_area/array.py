"""The pin array: no contact that pins can tell of is larger."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera
from casr.errors import AreaError
from casr.pins import pin_pitch_px


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
        what,
        wanted=f"at most the area of the pin array, {scale * array_px2:.5g} {unit}",
        found=f"{scale * area_px2:.5g} {unit}",
        do="Choose the area rule edge, law ode, or a region that lies among the pins.",
    )
