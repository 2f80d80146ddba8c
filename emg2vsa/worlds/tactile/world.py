"""What a world of the simulator is: how the skin moves, and how large the contact is, in a state of the contact.

The contact is an ellipse in the image; rays from its centre lead over its edge to the rim of the mask.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera
from casr.errors import SettingError

Array = NDArray[np.float64]
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
        """(n_points, 2) outline, px."""
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


@dataclass(frozen=True)
class ContactState:
    """A contact at one moment.

    radius_mm : of its edge, seen along the normal of the specimen. normal_n : force on the skin.
    tangential_mm : how far friction has pulled the skin of the contact along the surface, the way that surface climbs.
    """

    radius_mm: float
    normal_n: float
    tangential_mm: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Pressing:
    """Where and on what a sensor presses.

    stiffness_n_per_mm : of the specimen. specimen_height_mm : of it, which tells tables of several heights apart; None
    where they are of one. angle_deg : of the sensor's axis from the normal, towards +x. centre_mm : how
    far along x and y the contact lands from where it was meant to. camera, mask_radius_px : what sees it. start_n,
    peak_n : forces between which the press counts as loading. area_factor : of the contact in this press against that
    of the world.
    """

    stiffness_n_per_mm: float
    angle_deg: float
    centre_mm: tuple[float, float]
    camera: Camera
    mask_radius_px: float
    start_n: float
    peak_n: float
    area_factor: float
    specimen_height_mm: float | None = None


class PressedSkin(Protocol):
    """The skin of one press."""

    def state(self, force_n: float) -> ContactState:
        """State of a contact that a normal force, N, presses; the shipped worlds know no history."""

    def moved_px(self, rest_px: Points, state: ContactState) -> Points:
        """(N, 2) where tips of pins, at rest at (N, 2), are in that state."""

    def texture_px(self, points_px: Points, state: ContactState) -> Points:
        """(N, 2) where marks on the skin go that lie at (N, 2) at rest."""

    def contact(self, state: ContactState) -> ContactEllipse:
        """The edge as the camera sees it, as an ellipse."""

    def area_mm2(self, state: ContactState) -> float:
        """True area of the contact, mm2."""

    def skin_growth(self, before: ContactState, after: ContactState) -> float:
        """ln of how much larger the skin that was inside the contact at first becomes in the image between two states.

        At first: when the press counts as loading.
        """


class World(Protocol):
    """Mechanics of sensors and specimens."""

    @property
    def name(self) -> str:
        """In results."""

    @property
    def assumptions(self) -> tuple[str, ...]:
        """What is not known to be so."""

    def press(self, pressing: Pressing) -> PressedSkin:
        """The skin of one press."""


def check(fits: bool, what: str, wanted: str, found: str, do: str) -> None:
    """SettingError unless it fits."""
    if not fits:
        raise SettingError(what, wanted=wanted, found=found, do=do)
