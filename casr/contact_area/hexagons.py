"""One hexagon for each pin of the contact (paper, eqs 3 to 5)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera
from casr.flow.region import Region


def hexagon_radius_px(pitch_px: float) -> float:
    """Radius r_h of the hexagons that tile a grid of this pitch without gaps: the apothem is half the pitch."""
    return float(pitch_px / np.sqrt(3))


def hexagon_area(radius_px: float, camera: Camera | None) -> tuple[float, float | None]:
    """Area of one hexagon, px^2 and mm^2 (None without camera): a and l of eq. (3), in mm by (5), A = 6 l a / 2."""
    apothem_px, side_px = radius_px * np.cos(np.pi / 6), 2 * radius_px * np.sin(np.pi / 6)
    area_px2 = float(3 * side_px * apothem_px)
    if camera is None:
        return area_px2, None
    x_mm, y_mm = camera.mm_per_px
    return area_px2, float(3 * (side_px * x_mm) * (apothem_px * y_mm))


def hexagons_outline(centres_px: NDArray[np.float64], radius_px: float) -> NDArray[np.float64]:
    """(K, 2) convex hull of upright hexagons around (n, 2) centres, px."""
    angle = np.deg2rad(np.arange(30, 390, 60))
    corners = radius_px * np.column_stack([np.cos(angle), np.sin(angle)])
    return Region.from_points((centres_px[:, None] + corners).reshape(-1, 2)).polygon_px
