"""The contact as an ellipse in the image, and distances to its edge and to the mask along rays from its centre."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]


@dataclass(frozen=True)
class Rim:
    """The mask's edge, which never moves: centre and radius, px."""

    centre_px: tuple[float, float]
    radius_px: float


@dataclass(frozen=True)
class ContactEllipse:
    """A contact in the image.

    Parameters
    ----------
    centre_px : (x, y).
    semi_axes_px : along x and y; a tilted contact is foreshortened along x.
    """

    centre_px: tuple[float, float]
    semi_axes_px: tuple[float, float]

    @property
    def area_px2(self) -> float:
        """Area of the ellipse, px^2."""
        return math.pi * self.semi_axes_px[0] * self.semi_axes_px[1]

    def polygon_px(self, n_points: int = 720) -> Points:
        """(n_points, 2) outline."""
        angle = np.linspace(0, 2 * np.pi, n_points, endpoint=False)
        return np.column_stack([np.cos(angle), np.sin(angle)]) * self.semi_axes_px + self.centre_px

    def depth(self, points_px: Points) -> NDArray[np.float64]:
        """(N,) distance from the centre over the distance of the edge in that direction; 1 is the edge."""
        from_centre = np.asarray(points_px) - self.centre_px
        return np.hypot(from_centre[..., 0] / self.semi_axes_px[0], from_centre[..., 1] / self.semi_axes_px[1])

    def gap_px(self, rim: Rim, n_points: int = 720) -> float:
        """Least distance between the ellipse and the rim, px; negative where it reaches beyond."""
        outward = np.hypot(*(self.polygon_px(n_points) - rim.centre_px).T)
        return float(rim.radius_px - outward.max())


def rim_distance(from_centre_px: Points, contact: ContactEllipse, rim: Rim) -> NDArray[np.float64]:
    """(...) distance from the contact's centre to the rim through each point, px.

    ``from_centre_px`` is relative to the contact's centre; at the centre itself the direction is taken along x.
    """
    x, y = from_centre_px[..., 0], from_centre_px[..., 1]
    length = np.hypot(x, y)
    away = length > 0
    scale = 1 / np.where(away, length, 1.0)
    ex, ey = np.where(away, x * scale, 1.0), y * scale
    cx, cy = contact.centre_px[0] - rim.centre_px[0], contact.centre_px[1] - rim.centre_px[1]
    along = cx * ex + cy * ey
    return np.asarray(np.sqrt(along**2 + rim.radius_px**2 - cx**2 - cy**2) - along)
